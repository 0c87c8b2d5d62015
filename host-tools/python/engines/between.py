"""A server between a command and a bucket: passes on what is asked, counts it, and spoils what a test wants spoiled."""

import http.client
import http.server
import socket
import threading
import time
import urllib.parse


class Between:
    """In front of the server at `host` and `port`; what spoils is asked for each object with its path and how often it was asked for."""

    def __init__(self, host, port):
        self.behind, self.asked, self.lock = (host, port), {}, threading.Lock()
        self.spoil = lambda path, times: None
        between = self

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_GET(self):
                between.answer(self)

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self.server.server_port}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def answer(self, handler):
        path = urllib.parse.unquote(handler.path.split("?")[0])
        is_object = path.endswith(".parquet")
        with self.lock:
            times = self.asked[path] = self.asked.get(path, 0) + 1
        how = self.spoil(path, times) if is_object else None
        if how == "slow":
            time.sleep(0.1)
        if how == "refuse":
            handler.send_response(403)
            handler.send_header("Content-Length", "0")
            return handler.end_headers()
        behind = http.client.HTTPConnection(*self.behind, timeout=30)
        behind.request("GET", handler.path, headers=dict(handler.headers))
        found = behind.getresponse()
        body = found.read()
        behind.close()
        handler.send_response(found.status)
        for name, value in found.getheaders():
            if name.lower() not in ("content-length", "transfer-encoding", "connection", "server", "date"):
                handler.send_header(name, value)
        handler.send_header("Content-Length", str(len(body)))
        handler.end_headers()
        try:
            handler.wfile.write(body[: len(body) // 2] if how == "cut" else body)
        except OSError:
            # Whoever asked was killed.
            handler.close_connection = True
            return
        if how == "cut":
            handler.wfile.flush()
            handler.connection.shutdown(socket.SHUT_RDWR)
            handler.close_connection = True

    def objects(self):
        """How often each object was asked for."""
        with self.lock:
            return {path: times for path, times in self.asked.items() if path.endswith(".parquet")}

    def forget(self):
        with self.lock:
            self.asked.clear()
        self.spoil = lambda path, times: None

    def close(self):
        self.server.shutdown()
        self.server.server_close()
