"""The first lines of every page that is written: who wrote it, and what may run in it.

By the Content-Security-Policy nothing is loaded from anywhere, and no script runs but those that
the page was written with, whatever a name in it holds. Source: W3C, Content Security Policy 3.
"""

import base64
import hashlib
import re
from collections.abc import Iterable

from facetlog.output_file import OWN_PAGE

_SCRIPT = re.compile(r"<script[^>]*>(.*?)</script", re.DOTALL | re.IGNORECASE)


def make_head_lines(scripts: Iterable[str] = (), *, version: str) -> str:
    """Return the lines that follow a page's charset; `scripts` are those in it, and in its frames.

    A frame by `srcdoc` obeys the policy of its page. Pictures are in the page; the viewer in a
    frame reads its mesh by way of blobs and data URLs.
    """
    hashes = " ".join(f"'sha256-{_digest(script)}'" for script in scripts) or "'none'"
    policy = "; ".join(
        (
            "default-src 'none'",
            f"script-src {hashes}",
            "style-src 'unsafe-inline'",
            "img-src data: blob:",
            "connect-src data: blob:",
            "base-uri 'none'",
            "form-action 'none'",
        )
    )
    return (
        f'{OWN_PAGE.decode()} {version}">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
    )


def find_scripts(page: str) -> list[str]:
    """Return the scripts in the text of a page."""
    return _SCRIPT.findall(page)


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
