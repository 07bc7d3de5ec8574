import ballbar.alarm_t;
import ballbar.circle_result_t;
import ballbar.daemon_status_t;
import ballbar.gap_result_t;
import ballbar.line_result_t;
import java.io.EOFException;
import java.io.IOException;
import java.io.PrintStream;
import java.lang.reflect.Array;
import java.lang.reflect.Field;
import java.lang.reflect.Modifier;
import lcm.logging.Log;

/**
 * Reads an LCM log and prints every result of ballbard as the generated Java classes see it: one JSON object a line,
 * first "channel", then the fields in the order of the .lcm file. Doubles as Double.toString gives them, which reads
 * back to the same bits; NaN as "NaN". Other channels are left out.
 *
 * <p>usage: java -cp lcm.jar:ballbar-types.jar:. DecodeResults LOG; exit code 2 if something cannot be decoded.
 */
public final class DecodeResults {
  private DecodeResults() {}

  public static void main(String[] arguments) throws Exception {
    if (arguments.length != 1) {
      System.err.println("usage: DecodeResults LOG");
      System.exit(2);
    }
    // LCM's Java makes one char of each byte: so the bytes come out as they came in, and UTF-8 stays UTF-8.
    PrintStream out = new PrintStream(System.out, false, "ISO-8859-1");
    try {
      Log log = new Log(arguments[0], "r");
      while (true) {
        Log.Event event = log.readNext();
        Object message = decode(event.channel, event.data);
        if (message != null) {
          out.println(json(event.channel, message));
        }
      }
    } catch (EOFException end) {
      out.flush();
    } catch (IOException wrong) {
      out.flush();
      System.err.println("DecodeResults: " + arguments[0] + ": " + wrong.getMessage());
      System.exit(2);
    }
  }

  private static Object decode(String channel, byte[] data) throws IOException {
    switch (channel) {
      case "CIRCLE_RESULT":
        return new circle_result_t(data);
      case "LINE_RESULT":
        return new line_result_t(data);
      case "GAP_RESULT":
        return new gap_result_t(data);
      case "ALARM":
        return new alarm_t(data);
      case "BALLBARD_STATUS":
        return new daemon_status_t(data);
      default:
        return null;
    }
  }

  private static String json(String channel, Object message) throws IllegalAccessException {
    StringBuilder text = new StringBuilder("{\"channel\":" + quoted(channel));
    for (Field field : message.getClass().getFields()) {
      if (!Modifier.isStatic(field.getModifiers())) {
        text.append(",\"").append(field.getName()).append("\":").append(value(field.get(message)));
      }
    }
    return text.append('}').toString();
  }

  private static String value(Object value) {
    if (value.getClass().isArray()) {
      StringBuilder text = new StringBuilder("[");
      for (int i = 0; i < Array.getLength(value); i++) {
        text.append(i == 0 ? "" : ",").append(value(Array.get(value, i)));
      }
      return text.append(']').toString();
    }
    if (value instanceof Double && !Double.isFinite((Double) value)) {
      return quoted(value.toString());
    }
    return value instanceof Number || value instanceof Boolean ? value.toString() : quoted(value.toString());
  }

  private static String quoted(String text) {
    StringBuilder quoted = new StringBuilder("\"");
    for (char c : text.toCharArray()) {
      if (c == '"' || c == '\\') {
        quoted.append('\\').append(c);
      } else if (c < 0x20) {
        quoted.append(String.format("\\u%04x", (int) c));
      } else {
        quoted.append(c);
      }
    }
    return quoted.append('"').toString();
  }
}
