"""notify-mail and notify-webhook against real sockets: a small SMTP server, a small web server."""
import email
import email.policy
import http.server
import json
import os
import socket
import socketserver
import subprocess
import threading
import unittest

SCRIPTS = os.path.join(os.path.dirname(__file__), "../../scripts")
ALARM = {
    "version": 1, "event": 12, "at_us": 1700000000000000,
    "subject": "ballbard: firing (critical) ovality_high lrmate-1 A+1",
    "message": "ovality 31.2 µm is above 25 µm\n.\nballbar alarms show 3\n",
    "alarm": {"id": 3},
}


def run(script, *words, said=ALARM):
    text = said if isinstance(said, str) else json.dumps(said)
    return subprocess.run([os.path.join(SCRIPTS, script), *words], input=text, text=True, capture_output=True,
                          env={**os.environ, "no_proxy": "127.0.0.1"},
                          timeout=60, check=False)


def nobody():
    """A port at which nobody listens."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Smtp(socketserver.StreamRequestHandler):
    """Enough of RFC 5321 to take a mail."""

    def say(self, line):
        self.wfile.write(line.encode() + b"\r\n")

    def handle(self):
        self.say("220 test")
        while line := self.rfile.readline():
            word = line.split()[0].upper() if line.split() else b""
            if word == b"DATA":
                self.say("354 go on")
                mail = b""
                while (line := self.rfile.readline()) != b".\r\n":
                    mail += line[1:] if line.startswith(b".") else line
                self.server.mails.append(mail)
            elif word == b"RCPT":
                self.server.to.append(line.split(b"<")[1].split(b">")[0].decode())
                if b"refused@" in line:
                    self.say("550 no such user")
                    continue
            elif word == b"QUIT":
                self.say("221 bye")
                return
            self.say("250 ok")


class Web(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.posts.append((self.path, dict(self.headers), json.loads(body)))
        self.send_response(int(self.path.strip("/") or 200))
        self.end_headers()

    def log_message(self, *words):
        pass


class Serving:
    def __init__(self, handler):
        self.server = socketserver.TCPServer(("127.0.0.1", 0), handler)
        self.server.mails, self.server.to, self.server.posts = [], [], []

    def __enter__(self):
        threading.Thread(target=self.server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True).start()
        return self.server

    def __exit__(self, *why):
        self.server.shutdown()
        self.server.server_close()


class Mail(unittest.TestCase):
    def test_subject_message_and_every_recipient_arrive(self):
        with Serving(Smtp) as server:
            done = run("notify-mail", "anna@example.com", "bo@example.com", "--server",
                       f"127.0.0.1:{server.server_address[1]}", "--from", "cell@example.com")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertEqual(server.to, ["anna@example.com", "bo@example.com"])
            mail = email.message_from_bytes(server.mails[0], policy=email.policy.default)
            self.assertEqual(mail["Subject"], ALARM["subject"])
            self.assertEqual(mail["From"], "cell@example.com")
            self.assertEqual(mail.get_content().replace("\r\n", "\n"), ALARM["message"])
            self.assertIn("ballbard-12-", mail["Message-ID"])

    def test_a_server_that_refuses_or_is_not_there_is_tried_again(self):
        with Serving(Smtp) as server:
            at = f"127.0.0.1:{server.server_address[1]}"
            self.assertEqual(run("notify-mail", "refused@example.com", "--server", at).returncode, 1)
        done = run("notify-mail", "anna@example.com", "--server", f"127.0.0.1:{nobody()}")
        self.assertEqual(done.returncode, 1)
        self.assertIn("refused", done.stderr)

    def test_what_is_no_alarm_is_not_tried_again(self):
        for said in ("", "[]", "{}", '{"subject": 3}'):
            self.assertEqual(run("notify-mail", "anna@example.com", said=said).returncode, 65, said)


class Webhook(unittest.TestCase):
    def test_the_alarm_is_posted_as_it_is_or_as_text(self):
        with Serving(Web) as server:
            url = f"http://127.0.0.1:{server.server_address[1]}/200"
            self.assertEqual(run("notify-webhook", url, "--header", "Authorization: Bearer x").returncode, 0)
            self.assertEqual(run("notify-webhook", url, "--text").returncode, 0)
            (_, headers, whole), (_, _, text) = server.posts
            self.assertEqual(whole, ALARM)
            self.assertEqual(headers["Authorization"], "Bearer x")
            self.assertEqual(headers["Content-Type"], "application/json")
            self.assertEqual(text, {"text": ALARM["subject"] + "\n" + ALARM["message"]})

    def test_only_a_message_that_is_refused_for_itself_is_not_tried_again(self):
        with Serving(Web) as server:
            url = f"http://127.0.0.1:{server.server_address[1]}"
            codes = {status: run("notify-webhook", f"{url}/{status}").returncode for status in (400, 401, 404, 500)}
        self.assertEqual(codes, {400: 65, 401: 1, 404: 1, 500: 1})
        self.assertEqual(run("notify-webhook", f"http://127.0.0.1:{nobody()}/").returncode, 1)
        self.assertEqual(run("notify-webhook", "http://127.0.0.1:1/", said="{").returncode, 65)


if __name__ == "__main__":
    unittest.main()
