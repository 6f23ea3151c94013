"""Stands for `xllamacpp` in a server's process: the parts that are used, with scripted answers in place of a model.

A file of a model that ends with `broken` is refused. Requests are written beside the file, one a line.
"""

import json
import os
import re
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace

MOVES = ("north", "east", "west", "south")


class CommonParams(SimpleNamespace):
    def __init__(self):
        cores = {name: SimpleNamespace(n_threads=0) for name in ("cpuparams", "cpuparams_batch")}
        super().__init__(model=SimpleNamespace(path=""), **cores)


class llama_load_mode:  # noqa: N801 (as it is called there)
    LLAMA_LOAD_MODE_NONE = 0


class Server:
    def __init__(self, params):
        path = Path(params.model.path)
        if path.read_bytes().endswith(b"broken"):
            print("0.00 E load_model: failed to load model", flush=True)
            raise RuntimeError("Failed to init server, please check the input params.")
        time.sleep(float(os.environ.get("SCRIPTED_LOAD", "0")))
        longest = params.n_ctx // params.n_parallel

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                if self.headers["Authorization"] != f"Bearer {params.api_keys[0]}":
                    return self.reply(401, {"error": {"message": "Invalid API Key"}})
                with path.with_suffix(".requests").open("ab") as file:
                    file.write(body + b"\n")
                count = path.with_suffix(".requests").read_bytes().count(b"\n")
                if os.environ.get("SCRIPTED_DEATH") == f"{count}":
                    os._exit(9)
                request = json.loads(body)
                words = sum(len(f"{message['content']}".split()) for message in request["messages"])
                if words > longest:
                    said = f"request ({words} tokens) exceeds the available context size ({longest} tokens)"
                    return self.reply(400, {"error": {"message": said, "type": "exceed_context_size_error"}})
                told = request["messages"][-1]["content"]
                if "Your action?" in told:
                    told = "".join(re.findall(r"^Teacher: (.*)", told, re.MULTILINE)[-1:])
                way = [word for word in MOVES if word in told] or ["north"]
                said = {"thought": "so", "action": way[0]} if "response_format" in request else f"Response: {way[0]}"
                if "Say hello." in body.decode():  # the trial of a schema
                    said = {"word": "kelvin", "number": "-1.50"}
                message = {"role": "assistant", "content": said if isinstance(said, str) else json.dumps(said)}
                usage = {"prompt_tokens": words, "completion_tokens": 2, "total_tokens": words + 2}
                return self.reply(200, {
                    "model": "scripted", "usage": usage,
                    "choices": [{"index": 0, "finish_reason": "stop", "message": message}],
                })  # fmt: skip

            def reply(self, status, body):
                data = json.dumps(body).encode()
                self.send_response(status)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", f"{len(data)}")
                self.end_headers()
                self.wfile.write(data)

            def log_message(self, *arguments):
                pass

        server = ThreadingHTTPServer(("127.0.0.1", params.port), Handler)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.listening_address = f"http://127.0.0.1:{server.server_port}"
