"""The command line: one file per command. Exit status 0 done, 1 the work failed, 2 the call was wrong.

What commands work with is imported inside them, so that help, version and completion answer at once.
"""

import contextlib
import errno
import io
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from types import FrameType
from typing import Annotated, Any

import typer

from boom_mj.cli import calibrate, gap, generate, logs, render, replay, schema, simulate, track, validate, view
from boom_mj.cli.arguments import printable
from boom_mj.cli.many_logs import ManyLogs
from boom_mj.errors import BoomError, InputError, LogWarning, lacks_memory

QUIET = "--quiet"
AT_ONCE = {"--help", "--version", "--show-completion", "--install-completion"}  # need no MuJoCo


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"boom_mj {version('boom_mj')}, MuJoCo {version('mujoco')}, Python {sys.version.split()[0]}")
        raise typer.Exit


app = typer.Typer(
    help="""Flexible large manipulators in MuJoCo: generate models, simulate, replay logs, film, diagnose the gap.

    Results go to stdout, everything else to stderr. Exit status: 0 done, 1 the work failed, 2 the call was wrong.

    Example: python -m boom_mj simulate boom36 slew_t -o slew.mcap
    """,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
for command in (generate, simulate, replay, validate, view, render, track, schema):
    app.command(command.__name__.rpartition(".")[2])(command.command)
app.command("calibrate", cls=ManyLogs)(calibrate.command)
app.add_typer(logs.app, name="logs")
app.add_typer(gap.app, name="gap")


@app.callback()
def _options(
    version: Annotated[bool, typer.Option("--version", is_eager=True, callback=_version, help="Say which.")] = False,
    quiet: Annotated[bool, typer.Option(QUIET, help="Only results and errors; after the command as well.")] = False,
) -> None:
    pass


MOST_LINES, MOST_CHARACTERS = 20, 1000  # of a message, and of each of its lines
WRONG_CALL = 2
INTERRUPTED = 130  # what typer makes of Ctrl-C


_stops: list[int] = []  # signals that came: a binding to C++ may make an error of its own of an interrupt


def _stop(number: int, frame: FrameType | None) -> None:
    _stops.append(number)
    signal.default_int_handler(number, frame)


def main() -> None:
    """Run the command of this process and end with its exit status."""
    signal.signal(signal.SIGTERM, _stop)  # leave as by Ctrl-C: nothing half-written stays
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _stop)
    status = run()
    if status == 0:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is done: Ctrl-C is too late to make it fail
    sys.exit(status)


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a command; errors and warnings are one sentence on stderr, never a traceback.

    Args:
        arguments: of the command line; the process's own if left out.

    Returns:
        Exit status.
    """
    words = sys.argv[1:] if arguments is None else [*arguments]
    quiet = QUIET in words
    if words and not AT_ONCE & {*words}:
        from boom_mj.engine import keep_no_log
        from boom_mj.workers import return_memory

        keep_no_log()
        return_memory()
    warnings.simplefilter("always", LogWarning)
    warnings.showwarning = _show_warning
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files may be no text
    try:
        try:
            with _hushed() if quiet else contextlib.nullcontext():
                app([QUIET, *(word for word in words if word != QUIET)] if quiet else words)
        except SystemExit as end:
            sys.stdout.flush()
            if end.code != INTERRUPTED:
                return int(end.code or 0)
            return _failed("interrupted")
    except BoomError as error:
        return _failed(str(error), 2 if isinstance(error, InputError) else 1)
    except KeyboardInterrupt:
        return _failed("interrupted")
    except OSError as error:
        if error.errno == errno.ENOMEM:
            return _failed("there is not enough memory for this")
        if error.filename is None:  # the disk that stdout goes to is full
            sys.stdout = open(os.devnull, "w")  # noqa: SIM115
        return _failed(f"{error.filename or 'stdout'} cannot be used: {error.strerror or error}")
    except Exception as error:
        if _stops:
            return _failed("interrupted")
        if not lacks_memory(error):
            raise
        return _failed("there is not enough memory for this")
    return 0


@contextlib.contextmanager
def _hushed() -> Iterator[None]:
    """Keep what is said on stderr to oneself, unless the call was wrong."""
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            yield
    except SystemExit as end:
        if end.code == WRONG_CALL:
            print(said.getvalue(), end="", file=sys.stderr)
        raise


def _failed(text: str, status: int = 1) -> int:
    print(f"error: {_plain(text)}", file=sys.stderr)
    return status


def _show_warning(message: Warning | str, *args: Any, **kwargs: Any) -> None:
    print(f"warning: {_plain(str(message))}", file=sys.stderr)


def _plain(text: str) -> str:
    """A message as it may stand on a terminal, whatever a file has put into it."""
    lines = text.split("\n")
    if len(lines) > MOST_LINES:
        lines[MOST_LINES:] = [f"... and {len(lines) - MOST_LINES} more"]
    return "\n".join(
        printable(line if len(line) <= MOST_CHARACTERS else f"{line[:MOST_CHARACTERS]} ...") for line in lines
    )
