"""The paper's experiments: four loads hung from the tip, three pulled sideways, and the T-shaped pose."""

from boom_mj.simulation import CATALOGUE, Experiment


def _half(name: str) -> Experiment:
    whole = CATALOGUE[name]
    x, y, z = whole.load
    words = whole.description.replace("100 kg", "50 kg")
    return whole.model_copy(update={"name": f"{name}_half", "load": (x / 2, y / 2, z / 2), "description": words})


VERTICAL = (
    CATALOGUE["release_stretched_vertical"],
    CATALOGUE["release_stretched_vertical_half"],
    CATALOGUE["release_bow_vertical"],
    _half("release_bow_vertical"),
)
HORIZONTAL = (
    CATALOGUE["release_stretched_horizontal"],
    _half("release_stretched_horizontal"),
    CATALOGUE["release_bow_horizontal"],
)
T_SHAPED = CATALOGUE["slew_t"]
PAPER = (*VERTICAL, *HORIZONTAL, T_SHAPED)
