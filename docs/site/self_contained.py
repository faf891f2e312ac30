"""Refuses a site that would fetch anything from elsewhere: a reader without a network sees all of it."""

import re
from pathlib import Path

_FETCHED = re.compile(r"""<(?:script|link|img|iframe|source)\b[^>]*?\b(?:src|href)=["'](?:https?:)?//[^"']+["'][^>]*>""")
_IN_STYLES = re.compile(r"""(?:@import\s+["']|url\(\s*["']?)(?:https?:)?//[^"')]+""")


def fetched_from_elsewhere(text):
    """What of a page or a style sheet a browser would fetch from another host."""
    return _FETCHED.findall(text) + _IN_STYLES.findall(text)


def _check(app, exception):
    if exception is not None or app.builder.format != "html":
        return
    files = [path for kind in ("*.html", "*.css") for path in Path(app.outdir).rglob(kind)]
    found = [f"{path.name}: {link}" for path in files for link in fetched_from_elsewhere(path.read_text(encoding="utf-8"))]
    if found:
        raise RuntimeError("the site is not self-contained:\n" + "\n".join(sorted(set(found))))


def setup(app):
    """Look at every page once all are written."""
    app.connect("build-finished", _check)
    return {"parallel_read_safe": True}
