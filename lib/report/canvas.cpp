#include "report/canvas.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kRow = 26;          // [px] of legend and notes
constexpr int kSmallestFont = 9;  // [px]
constexpr std::size_t kMostNotes = 6;

using Shades = std::array<std::string_view, kMostOwn>;
constexpr Shades kPositive{"#0072B2", "#56B4E9", "#003B5C"};
constexpr Shades kNegative{"#D55E00", "#E69F00", "#7A3500"};
constexpr Shades kUnknown{"#333333", "#888888", "#000000"};

struct Tones {
  std::string_view dark, light;
};
constexpr std::array<Tones, 5> kGroups{Tones{"#0072B2", "#56B4E9"}, Tones{"#D55E00", "#E69F00"},
                                       Tones{"#00785A", "#5CC4A4"}, Tones{"#8F2F6B", "#CC79A7"},
                                       Tones{"#333333", "#999999"}};

}  // namespace

Stroke stroke_of(std::size_t groups, std::size_t group, int direction, std::size_t shade) {
  const std::string_view dash = direction > 0 ? "solid" : direction < 0 ? "(14,5)" : "(3,4)";
  const int point = direction > 0 ? 7 : direction < 0 ? 4 : 2;  // filled circle, open square, cross
  if (groups > 1) {
    const Tones& tones = kGroups.at(group % kGroups.size());
    return {direction < 0 ? tones.light : tones.dark, dash, point};
  }
  const Shades& shades = direction > 0 ? kPositive : direction < 0 ? kNegative : kUnknown;
  return {shades.at(shade), dash, point};
}

std::size_t Groups::of(const std::string& name) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  names_.push_back(name);
  return names_.size() - 1;
}

std::string join(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) all += part;
  return all;
}

std::string shown(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 400> buffer{};  // the longest double has 309 digits before the point
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
  const std::string digits(buffer.data(), end.ptr);
  return digits.front() == '-' && digits.find_first_not_of("-0.") == std::string::npos ? digits.substr(1)
                                                                                       : digits;
}

std::string centred(std::string_view text, const std::string& place, int wanted_px) {
  constexpr double kCharacterWidth = 0.5;  // of the font's height, mean of DejaVu Sans
  const auto characters =
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0U) != 0x80U; });
  const double fitting =
      (kWidth - 16) / (kCharacterWidth * static_cast<double>(std::max<std::ptrdiff_t>(characters, 1)));
  const int size = fitting > wanted_px ? wanted_px : std::max(static_cast<int>(fitting), kSmallestFont);
  return "set label " + gnuplot_quoted(text) + " at screen 0.5," + place + " center font '," +
         std::to_string(size) + "'\n";
}

PlotScript canvas(const std::string& title, const std::string& subtitle,
                  const std::vector<std::string>& notes, std::size_t legend_rows, int drawing_px, int axis_px,
                  int above_px) {
  const int note_rows = static_cast<int>(std::min(notes.size(), kMostNotes));
  const int bottom = axis_px + kRow * (static_cast<int>(legend_rows) + note_rows);
  PlotScript script{kWidth, kTop + above_px + drawing_px + bottom, "set encoding utf8\n"};
  const auto screen = [&](double px_from_below) {
    return "screen " + plain_number(px_from_below / script.height, 4);
  };

  const double top = script.height;
  script.text += centred(title, screen(top - 26), 22) + centred(subtitle, screen(top - 54), 17);
  for (int i = 0; i < note_rows; ++i)
    script.text += centred(notes[static_cast<std::size_t>(i)], screen(16 + kRow * (note_rows - 1 - i)), 16);
  script.text +=
      "set bmargin at " + screen(bottom) + "\nset tmargin at " + screen(top - kTop - above_px) + "\n";
  script.text += "set key at screen 0.5," + screen(8 + kRow * note_rows) +
                 " center bottom vertical Left reverse samplen 3 maxcols 1 spacing 1.1\n";
  return script;
}

std::string axes(const std::string& x_label, const std::string& y_label) {
  const std::string ink(kInk);
  return "set lmargin at screen 0.13\nset rmargin at screen 0.96\nset border 3 linecolor rgb '" + ink +
         "'\nset tics nomirror\nset grid linecolor rgb '" + std::string(kGrid) +
         "' linewidth 0.8 dashtype solid\nset xzeroaxis linecolor rgb '" + ink +
         "' linewidth 1.2 dashtype solid\nset xlabel " + gnuplot_quoted(x_label) + "\nset ylabel " +
         gnuplot_quoted(y_label) + "\n";
}

}  // namespace ballbar
