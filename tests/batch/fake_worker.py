"""A worker process without an engine, which does what the name of a file says.

`die-…` ends itself, `once-…` only the first time, `full-…` as one does whose memory ran out,
`busy-…` works for ever, `slow-…` waits for ever unless there is a file `slow-….quick`, `bad-…` is
an error, `plain-…` has no page; any other holds for the model that its name begins with. Models
called `refused` cannot be opened, a worker of `dead` ones never starts, and one of `late` ones,
which are a file, only once so many died at it as the file says. It loads nothing of facetlog: it
starts at once.
"""

import json
import os
import signal
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

MODELS = ("box", "table", "chair")
PAUSE = "FAKE_WORKER_PAUSE"
"""Environment variable: seconds that each scene takes."""


def fake_row(path: str, models: tuple[str, ...], read_as: str = "degrees") -> dict[str, Any]:
    """The row that this program makes of a file; by the models `better` with another degree."""
    stem = Path(path).stem
    degree = 0.5 if "better" in models else 0.9
    holding = next((model for model in MODELS if stem.startswith(model)), None)
    bad = stem.startswith(("bad", "full")) or not Path(path).exists()
    verdicts = [
        {
            "model": model,
            "thing": "t1",
            "state": "holds" if model == holding else "fails",
            "degree": degree if model == holding else 0.0,
            "degree_at_most": degree if model == holding else 0.0,
            "confidence": None,
            "parts": [{"role": "top", "names": ["f1", "f2"]}],
            "sizes": [{"name": "width", "value": 0.5, "sd": 0.01}],
        }
        for model in MODELS
    ]
    known = holding is not None and not bad
    return {
        "path": path,
        "sha256": None if bad else stem,
        "models_hash": hash_of(models),
        "model": holding if known else None,
        "thing": "t1" if known else None,
        "degree": degree if known else None,
        "confidence": None,
        "verdicts": [] if bad else verdicts,
        "faces": None if bad else 6,
        "things": None if bad else 1,
        "seconds": 0.25,
        "error": f"{path}: is bad" if bad else None,
        "warnings": [f"{stem} is doubtful"] if stem.startswith("table") else [],
        "up": None if bad else [0.0, 0.0, 1.0],
        "metric": None if bad else True,
        "read_as": read_as,
        "facetlog": "0.1.0",
    }


def hash_of(models: tuple[str, ...]) -> str:
    """What stands for the hash of models of these names."""
    return "hash of " + ", ".join(models)


def main() -> None:
    """Serves until the other side goes away."""
    connection = Connection(os.dup(0))
    settings = json.loads(connection.recv_bytes())
    models = tuple(Path(m).name for m in settings["models"])
    judged = "crisp" if settings["crisp"] else "degrees"
    if "dead" in models:
        os._exit(3)
    if "late" in models:
        path = Path(settings["models"][models.index("late")])
        left = int(path.read_text())
        path.write_text(str(left - 1))
        if left > 0:
            os.kill(os.getpid(), signal.SIGKILL)
    if "refused" in models:
        refusal = json.dumps({"kind": "rules", "error": "refused:1: no model"})
        connection.send_bytes(b"!" + refusal.encode())
        return
    ready = {"models_hash": hash_of(models), "models": MODELS}
    connection.send_bytes(b"=" + json.dumps(ready).encode())
    while True:
        for task in json.loads(connection.recv_bytes()):
            connection.send_bytes(_answer(task, models, judged))
            if Path(task["path"]).stem.startswith("full"):
                return


def _answer(task: dict[str, Any], models: tuple[str, ...], judged: str) -> bytes:
    stem = Path(task["path"]).stem
    mark = Path(task["path"]).with_suffix(".seen")
    if stem.startswith("die") or (stem.startswith("once") and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    while stem.startswith("busy"):
        pass
    if stem.startswith("slow") and not Path(task["path"]).with_suffix(".quick").exists():
        time.sleep(1000)
    time.sleep(float(os.environ.get(PAUSE, "0")))
    if "explain" in task:
        reasons = [{"title": f"Why not {task['explain']['right']}", "lines": ["a <top> & legs"]}]
        return b"?" + json.dumps({"picture": "UE5H", "reasons": reasons}).encode()
    if "page" in task:
        assert task["page"] == stem
        if stem.startswith("plain"):
            return b"#" + json.dumps({"page": None, "error": "cannot be shown"}).encode()
        return b"#" + json.dumps({"page": f"<p>{task['path']}</p>", "error": None}).encode()
    read = "".join(f"{key}={task[key]} " for key in ("up", "unit") if key in task)
    row = fake_row(task["path"], models, read + judged)
    word = b"*" if stem.startswith("full") else b"-" if row["error"] else b"+"
    return word + json.dumps(row).encode()


if __name__ == "__main__":
    try:
        main()
    except (EOFError, OSError):
        os._exit(0)
