"""Pictures: compute below, draw on top. Measured is near-black, nominal vermilion, corrected blue, everywhere."""

from boom_mj.report.overlay import draw_overlay as draw_overlay
