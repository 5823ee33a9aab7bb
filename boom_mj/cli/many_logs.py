"""Options that take several logs."""

from typing import Any

from typer.core import TyperCommand


class ManyLogs(TyperCommand):
    """`--holdout A B C` means `--holdout A --holdout B --holdout C`; the same for `--healthy`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        spread: list[str] = []
        within = ""
        for word in args:
            if word in ("--holdout", "--healthy"):
                within = word
            elif word.startswith("-"):
                within = ""
                spread.append(word)
            else:
                spread += [within, word] if within else [word]
        return super().parse_args(ctx, spread)
