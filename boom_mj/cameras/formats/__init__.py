"""Data sets in the layouts that people load: one file per layout, made from the labels of all frames."""

from boom_mj.cameras.formats.bop import write_bop as write_bop
from boom_mj.cameras.formats.coco import write_coco as write_coco
from boom_mj.cameras.formats.nerfstudio import write_nerfstudio as write_nerfstudio
