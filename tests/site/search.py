#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The search of a built site in a browser, from a plain server and without a network: search.py SITE WORDS PAGE

Searches for WORDS on the first page. Exit status 0 where PAGE is among what is found, 1 where it is not, 77 (1 in CI) where
there is no chromium.
"""
import http.server
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import urllib.parse

SECONDS = 30
# Shows what the search of the frame has found as soon as there is something; the picture keeps the page loading until then.
FRAME = """<!doctype html><iframe src="/index.html?q={words}" width="1200" height="800"></iframe><p id="found"></p>
<img src="/picture"><script>
setInterval(() => {{
  const links = [...document.querySelector('iframe').contentDocument.querySelectorAll('.md-search-result__link')];
  if (!links.length) return;
  document.querySelector('#found').textContent = links.map(link => new URL(link.href).pathname).join(' ');
  fetch('/done');
}}, 100);</script>"""


def handler(site, words, done):
    class Handler(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments):
            super().__init__(*arguments, directory=site)

        def do_GET(self):
            if self.path == "/frame":
                self.answer(FRAME.format(words=urllib.parse.quote(words)).encode())
            elif self.path == "/picture":
                done.wait(SECONDS)
                self.answer(b"")
            elif self.path == "/done":
                done.set()
                self.answer(b"")
            else:
                super().do_GET()

        def answer(self, body):
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, *_):
            pass
    return Handler


def page_after_search(site, words):
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler(site, words, threading.Event()))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory() as profile:
        command = ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                   "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--user-data-dir=" + profile, "--dump-dom",
                   f"http://127.0.0.1:{server.server_port}/frame"]
        return subprocess.run(command, capture_output=True, text=True, timeout=4 * SECONDS).stdout


def main(site, words, page):
    if not shutil.which("chromium"):
        print("SKIPPED: no chromium (Debian package chromium)")
        return 1 if os.environ.get("CI") == "true" else 77
    begin = time.monotonic()
    shown = page_after_search(site, words)
    found = shown.partition('id="found">')[2].partition("</p>")[0].split()
    print(f"'{words}' found {len(found)} pages or sections in {time.monotonic() - begin:.1f} s")
    if "/" + page in found:
        return 0
    print(f"{page} is not among them: {' '.join(found)}")
    return 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
