"""The command line: one file per command. Exit status 0 done, 1 the work failed, 2 the call was wrong."""

import io
import os
import signal
import sys
import warnings
from collections.abc import Sequence
from typing import Any

import typer

from boom_mj.cli import calibrate, gap, generate, logs, render, replay, simulate, track, validate, view
from boom_mj.cli.arguments import ManyHoldouts, printable
from boom_mj.engine import keep_no_log
from boom_mj.errors import BoomError, InputError, LogWarning

app = typer.Typer(
    help="""Flexible large manipulators in MuJoCo: generate models, simulate, replay logs, film, diagnose the gap.

    Example: python -m boom_mj simulate boom36 slew_t -o slew.mcap
    """,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for command in (generate, simulate, replay, validate, view, render, track):
    app.command(command.__name__.rpartition(".")[2])(command.command)
app.command("calibrate", cls=ManyHoldouts)(calibrate.command)
app.add_typer(logs.app, name="logs")
app.add_typer(gap.app, name="gap")


MOST_LINES, MOST_CHARACTERS = 20, 1000  # of a message, and of each of its lines
INTERRUPTED = 130  # what typer makes of Ctrl-C


def main() -> None:
    """Run the command of this process and end with its exit status."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # leave as by Ctrl-C: nothing half-written stays
    sys.exit(run())


def run(arguments: Sequence[str] | None = None) -> int:
    """Run a command; errors and warnings are one sentence on stderr, never a traceback.

    Args:
        arguments: of the command line; the process's own if left out.

    Returns:
        Exit status.
    """
    keep_no_log()
    warnings.simplefilter("always", LogWarning)
    warnings.showwarning = _show_warning
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # names of files may be no text
    try:
        try:
            app(arguments)
        except SystemExit as end:
            sys.stdout.flush()
            if end.code != INTERRUPTED:
                return int(end.code or 0)
            return _failed("interrupted")
    except BoomError as error:
        return _failed(str(error), 2 if isinstance(error, InputError) else 1)
    except KeyboardInterrupt:
        return _failed("interrupted")
    except MemoryError:
        return _failed("there is not enough memory for this")
    except OSError as error:
        if error.filename is None:  # the disk that stdout goes to is full
            sys.stdout = open(os.devnull, "w")  # noqa: SIM115
        return _failed(f"{error.filename or 'stdout'} cannot be used: {error.strerror or error}")
    return 0


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
