"""The command line: one file per command. Exit status 0 done, 1 the work failed, 2 the call was wrong."""

import sys
import warnings
from typing import Any

import typer

from boom_mj.cli import calibrate, gap, generate, logs, render, replay, simulate, track, validate, view
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
app.command("calibrate", cls=gap.ManyHoldouts)(calibrate.command)
app.add_typer(logs.app, name="logs")
app.add_typer(gap.app, name="gap")


def main() -> None:
    """Run a command; errors and warnings are one sentence on stderr, never a traceback."""
    warnings.simplefilter("always", LogWarning)
    warnings.showwarning = _show_warning
    try:
        app()
    except BoomError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(2 if isinstance(error, InputError) else 1)
    except KeyboardInterrupt:
        print("error: interrupted", file=sys.stderr)
        sys.exit(1)


def _show_warning(message: Warning | str, *args: Any, **kwargs: Any) -> None:
    print(f"warning: {message}", file=sys.stderr)
