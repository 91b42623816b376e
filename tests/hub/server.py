"""A server on this machine that speaks as much of the Hub's API as publishing and loading need."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import unquote, urlsplit

import yaml

LARGE = (".parquet", ".mp4", ".mcap", ".safetensors", ".jpg")
REPOSITORY = r"(?:(?P<kind>datasets|models)/)?(?P<id>[\w.-]+/[\w.-]+)"


@dataclass
class Repository:
    """Commits as whole trees: path -> (content, whether it is a large file)."""

    private: bool
    commits: dict[str, dict[str, tuple[bytes, bool]]] = field(default_factory=dict)
    refs: dict[str, str] = field(default_factory=dict)  # "main", tags
    messages: list[str] = field(default_factory=list)

    def commit(self, tree: dict[str, tuple[bytes, bool]], message: str) -> str:
        self.messages.append(message)
        oid = hashlib.sha1(f"{len(self.commits)} {message}".encode()).hexdigest()
        self.commits[oid] = tree
        self.refs["main"] = oid
        return oid

    def tree(self, revision: str) -> dict[str, tuple[bytes, bool]] | None:
        return self.commits.get(self.refs.get(revision, revision))


@dataclass
class Hub:
    """What the server holds, what it was asked, and where it cuts connections.

    Attributes:
        cut: steps at which a connection is cut: "upload" (after `whole_uploads` more of them),
            "commit" before it is made, "answer" after it was made, "tag".
    """

    token: str
    url: str = ""
    repositories: dict[tuple[str, str], Repository] = field(default_factory=dict)
    storage: dict[str, bytes] = field(default_factory=dict)
    uploads: list[str] = field(default_factory=list)
    requests: list[str] = field(default_factory=list)
    cut: set[str] = field(default_factory=set)
    whole_uploads: int = 0
    fail: dict[str, tuple[int, str]] = field(default_factory=dict)  # step -> status and message
    lock: threading.Lock = field(default_factory=threading.Lock)


@contextmanager
def serving(hub: Hub) -> Iterator[Hub]:
    server = ThreadingHTTPServer(("127.0.0.1", 0), type("Bound", (Handler,), {"hub": hub}))
    hub.url = f"http://127.0.0.1:{server.server_address[1]}"
    thread = threading.Thread(target=server.serve_forever, args=(0.02,))
    thread.start()
    try:
        yield hub
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class Handler(BaseHTTPRequestHandler):
    hub: Hub
    protocol_version = "HTTP/1.1"

    def log_message(self, format: str, *args: object) -> None:
        pass

    def do_GET(self) -> None:
        self._answer("GET")

    def do_HEAD(self) -> None:
        self._answer("HEAD")

    def do_POST(self) -> None:
        self._answer("POST")

    def do_PUT(self) -> None:
        self._answer("PUT")

    def do_DELETE(self) -> None:
        self._answer("DELETE")

    def _answer(self, method: str) -> None:
        path = unquote(urlsplit(self.path).path)
        with self.hub.lock:
            self.hub.requests.append(f"{method} {path}")
        for pattern, name in ROUTES:
            if match := re.fullmatch(pattern, f"{method} {path}"):
                groups = match.groupdict()
                if name != "upload" and not self._allowed(name):
                    return
                getattr(self, name)(**groups)
                return
        self._send(404, {"error": f"no route for {method} {path}"})

    def _allowed(self, step: str) -> bool:
        if step in self.hub.fail:
            self._body()
            status, message = self.hub.fail[step]
            self._send(status, {"error": message.format(self.headers["Authorization"])})
            return False
        if self.headers.get("Authorization") != f"Bearer {self.hub.token}":
            self._body()
            self._send(401, {"error": "Invalid username or password."})
            return False
        if step in self.hub.cut:
            self._cut()
            return False
        return True

    # -- what is asked --------------------------------------------------------------------------

    def create(self) -> None:
        asked = json.loads(self._body())
        id, kind = f"{asked['organization']}/{asked['name']}", asked.get("type", "model")
        url = f"{self.hub.url}/{'datasets/' if kind == 'dataset' else ''}{id}"
        if (kind, id) in self.hub.repositories:
            self._send(409, {"error": "You already created this repo", "url": url})
            return
        repository = Repository(private=asked.get("visibility") == "private")
        repository.commit({".gitattributes": (b"*.parquet filter=lfs\n", False)}, "initial commit")
        self.hub.repositories[kind, id] = repository
        self._send(200, {"url": url, "name": id, "id": id})

    def validate(self) -> None:
        asked = json.loads(self._body())
        block = re.match(r"---\n(.*?)\n---\n", asked["content"], re.DOTALL)
        errors = header_errors(yaml.safe_load(block[1]) if block else None, asked["repoType"])
        status = 400 if errors else 200
        self._send(status, {"errors": [{"message": e} for e in errors], "warnings": []})

    def info(self, kind: str, id: str, revision: str | None) -> None:
        repository = self._repository(kind, id)
        if repository is None:
            return
        revision = revision or "main"
        if repository.tree(revision) is None:
            self._no_revision(revision)
            return
        sha = repository.refs.get(revision, revision)
        files = [{"rfilename": path} for path in repository.commits[sha]]
        self._send(200, {"id": id, "sha": sha, "private": repository.private, "siblings": files})

    def refs(self, kind: str, id: str) -> None:
        repository = self._repository(kind, id)
        if repository is None:
            return
        listed: dict[str, list[dict[str, str]]] = {"branches": [], "tags": [], "converts": []}
        for name, commit in repository.refs.items():
            kinds = ("branches", "heads") if name == "main" else ("tags", "tags")
            ref = {"name": name, "ref": f"refs/{kinds[1]}/{name}", "targetCommit": commit}
            listed[kinds[0]].append(ref)
        self._send(200, listed)

    def tree(self, kind: str, id: str, revision: str) -> None:
        repository = self._repository(kind, id)
        tree = repository.tree(revision) if repository else None
        if tree is None:
            self._no_revision(revision)
            return
        entries = []
        for path, (content, large) in tree.items():
            entry: dict[str, Any] = {"type": "file", "path": path, "size": len(content),
                                     "oid": git_oid(content)}  # fmt: skip
            if large:
                entry["lfs"] = {"oid": sha256(content), "size": len(content), "pointerSize": 130}
            entries.append(entry)
        self._send(200, entries)

    def preupload(self, kind: str, id: str, revision: str) -> None:
        asked = json.loads(self._body())["files"]
        repository = self._repository(kind, id)
        if repository is None:
            return
        tree = repository.tree(revision) or {}
        files = []
        for file in asked:
            content, large = tree.get(file["path"], (None, False))
            oid = None if content is None else (sha256 if large else git_oid)(content)
            mode = "lfs" if file["path"].endswith(LARGE) else "regular"
            known = {"path": file["path"], "uploadMode": mode, "shouldIgnore": False, "oid": oid}
            files.append(known)
        self._send(200, {"files": files})

    def batch(self, kind: str | None, id: str) -> None:
        objects = []
        for wanted in json.loads(self._body())["objects"]:
            one = {"oid": wanted["oid"], "size": wanted["size"]}
            if wanted["oid"] not in self.hub.storage:
                one["actions"] = {"upload": {"href": f"{self.hub.url}/storage/{wanted['oid']}"}}
            objects.append(one)
        self._send(200, {"transfer": "basic", "objects": objects})

    def upload(self, oid: str) -> None:
        with self.hub.lock:
            cut = "upload" in self.hub.cut and self.hub.whole_uploads <= 0
            self.hub.whole_uploads -= 1
        if cut:
            self._cut()
            return
        content = self._body()
        assert sha256(content) == oid
        with self.hub.lock:
            self.hub.storage[oid] = content
            self.hub.uploads.append(oid)
        self._send(200, {})

    def commit(self, kind: str, id: str, revision: str) -> None:
        lines = [json.loads(line) for line in self._body().splitlines()]
        repository = self._repository(kind, id)
        if repository is None:
            return
        parent = lines[0]["value"].get("parentCommit")
        if parent and parent != repository.refs[revision]:
            self._send(412, {"error": "A commit has happened since."})
            return
        tree = dict(repository.tree(revision) or {})
        for line in lines[1:]:
            value = line["value"]
            match line["key"]:
                case "file":
                    tree[value["path"]] = (base64.b64decode(value["content"]), False)
                case "lfsFile":
                    tree[value["path"]] = (self.hub.storage[value["oid"]], True)
                case "deletedFile":
                    del tree[value["path"]]
        oid = repository.commit(tree, lines[0]["value"]["summary"])
        if "answer" in self.hub.cut:
            self.close_connection = True
            return
        self._send(200, {"commitUrl": f"{self.hub.url}/{id}/commit/{oid}", "commitOid": oid})

    def tag(self, kind: str, id: str, revision: str) -> None:
        asked = json.loads(self._body())
        repository = self._repository(kind, id)
        assert repository is not None
        if asked["tag"] in repository.refs:
            self._send(409, {"error": "Tag reference exists already"})
            return
        repository.refs[asked["tag"]] = repository.refs.get(revision, revision)
        self._send(200, {})

    def untag(self, kind: str, id: str, tag: str) -> None:
        repository = self._repository(kind, id)
        assert repository is not None
        del repository.refs[tag]
        self._send(200, {})

    def resolve(self, kind: str | None, id: str, revision: str, path: str) -> None:
        repository = self._repository(kind or "models", id)
        tree = repository.tree(revision) if repository else None
        if repository is None or tree is None or path not in tree:
            self._send(404, {}, {"X-Error-Code": "EntryNotFound"})
            return
        content, large = tree[path]
        commit = repository.refs.get(revision, revision)
        etag = sha256(content) if large else git_oid(content)
        self._send(200, content, {"X-Repo-Commit": commit, "ETag": f'"{etag}"'})

    # -- how it is answered ---------------------------------------------------------------------

    def _repository(self, kind: str, id: str) -> Repository | None:
        repository = self.hub.repositories.get((kind.removesuffix("s"), id))
        if repository is None:
            self._send(404, {"error": "Repository not found"}, {"X-Error-Code": "RepoNotFound"})
        return repository

    def _no_revision(self, revision: str) -> None:
        message = {"error": f"Invalid rev id: {revision}"}
        self._send(404, message, {"X-Error-Code": "RevisionNotFound"})

    def _cut(self) -> None:
        """Take some of what is sent, and hang up."""
        self.rfile.read1(1024)
        self.close_connection = True
        self.connection.shutdown(2)

    def _body(self) -> bytes:
        if self.headers.get("Transfer-Encoding") != "chunked":
            return self.rfile.read(int(self.headers.get("Content-Length") or 0))
        parts = []
        while size := int(self.rfile.readline(), 16):
            parts.append(self.rfile.read(size))
            self.rfile.readline()
        self.rfile.readline()
        return b"".join(parts)

    def _send(self, status: int, content: object, headers: dict[str, str] | None = None) -> None:
        body = content if isinstance(content, bytes) else json.dumps(content).encode()
        self.send_response(status)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)


API = r"/api/(?P<kind>datasets|models)/(?P<id>[^/]+/[^/]+)"
ROUTES = [
    (r"POST /api/repos/create", "create"),
    (r"POST /api/validate-yaml", "validate"),
    (rf"POST {API}/preupload/(?P<revision>.+)", "preupload"),
    (rf"POST {API}/commit/(?P<revision>.+)", "commit"),
    (rf"POST {API}/tag/(?P<revision>.+)", "tag"),
    (rf"DELETE {API}/tag/(?P<tag>.+)", "untag"),
    (rf"GET {API}/refs", "refs"),
    (rf"GET {API}/tree/(?P<revision>[^/]+)/?", "tree"),
    (rf"GET {API}(?:/revision/(?P<revision>.+))?", "info"),
    (rf"POST /{REPOSITORY}\.git/info/lfs/objects/batch", "batch"),
    (r"PUT /storage/(?P<oid>\w+)", "upload"),
    (rf"(?:GET|HEAD) /{REPOSITORY}/resolve/(?P<revision>[^/]+)/(?P<path>.+)", "resolve"),
]

# Of the Hub's own lists, what cards of robots may name (hub-docs, datasetcard.md and modelcard.md).
SIZES = ("n<1K", "1K<n<10K", "10K<n<100K", "100K<n<1M", "1M<n<10M")


def header_errors(header: Any, kind: str) -> list[str]:
    """What the Hub would refuse in a card's YAML header."""
    if not isinstance(header, dict):
        return ["the metadata is no mapping"]
    errors = []
    if header.get("license", "cc-by-4.0") not in ("apache-2.0", "cc-by-4.0"):
        errors.append('"license" must be one of the known licences')
    if not all(isinstance(tag, str) and tag for tag in header.get("tags", [None])):
        errors.append('"tags" must be a list of strings')
    if kind == "dataset":
        if header.get("task_categories") != ["robotics"]:
            errors.append('"task_categories" must be known ones')
        if not all(size in SIZES for size in header.get("size_categories", [None])):
            errors.append('"size_categories" must be known ones')
        for config in header.get("configs", [{}]):
            if not {"config_name", "data_files"} <= set(config):
                errors.append('"configs" need a name and files')
    for index in header.get("model-index", []):
        for result in index["results"]:
            if not all(isinstance(m["value"], float | int) for m in result["metrics"]):
                errors.append('"model-index" needs values')
            if not {"type", "name"} <= set(result["dataset"]) or "type" not in result["task"]:
                errors.append('"model-index" needs a task and a dataset')
    return errors


def sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def git_oid(content: bytes) -> str:
    return hashlib.sha1(b"blob %d\0" % len(content) + content).hexdigest()
