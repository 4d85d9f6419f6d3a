"""Progress of long calls: a callable, or a bar in notebooks where tqdm is installed."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from importlib import import_module
from typing import Any, Callable, Iterator, Optional, Union

Progress = Union[None, bool, Callable[[str, Optional[float], str], object]]
"""What is told of a call's stages: `False` nothing, `None` a bar in notebooks, `True` a bar everywhere, or a callable that is given the
stage's name, its seconds (`None` at its beginning) and a note. An exception of the callable ends the call."""

Watcher = Optional[Callable[[str, Optional[float], str], object]]


def _in_notebook() -> bool:
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and type(shell).__name__ == "ZMQInteractiveShell"


@contextmanager
def watched(progress: Progress, name: str) -> Iterator[Watcher]:
    """The callable for the native part."""
    if callable(progress):
        yield progress
        return
    bar_class = _bar_class() if progress or (progress is None and _in_notebook()) else None
    if bar_class is None:
        yield None
        return
    with bar_class(desc=name, bar_format="{desc} {elapsed} {postfix}") as bar:
        yield lambda stage, seconds, note: _show(bar, stage, seconds, note)


def _bar_class() -> Any:
    try:
        return import_module("tqdm.auto").tqdm
    except ImportError:
        return None


def _show(bar: Any, stage: str, seconds: Optional[float], note: str) -> None:
    if seconds is None:
        bar.set_postfix_str(stage)
    else:
        bar.set_postfix_str(f"{stage}: {note}" if note else stage)
        bar.update(1)
