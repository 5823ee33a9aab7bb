"""Pictures: compute below, draw on top. Measured is near-black, nominal vermilion, corrected blue, everywhere."""

from typing import TYPE_CHECKING

from boom_mj.doors import door

if TYPE_CHECKING:
    from boom_mj.report.calibration import write_calibration as write_calibration
    from boom_mj.report.diagnosis import draw_gaps as draw_gaps
    from boom_mj.report.diagnosis import write_diagnosis as write_diagnosis
    from boom_mj.report.discovery import write_discovery as write_discovery
    from boom_mj.report.overlay import draw_overlay as draw_overlay
    from boom_mj.report.overlay import draw_pair as draw_pair
    from boom_mj.report.overlay import draw_ratios as draw_ratios
    from boom_mj.report.overlay import draw_shapes as draw_shapes
    from boom_mj.report.watching import draw_watch as draw_watch
else:
    __getattr__, __dir__, __all__ = door(
        __name__,
        {
            "boom_mj.report.calibration": ("write_calibration",),
            "boom_mj.report.diagnosis": ("draw_gaps", "write_diagnosis"),
            "boom_mj.report.discovery": ("write_discovery",),
            "boom_mj.report.overlay": ("draw_overlay", "draw_pair", "draw_ratios", "draw_shapes"),
            "boom_mj.report.watching": ("draw_watch",),
        },
    )
