"""Pictures of a chequerboard for the intrinsics of a camera: where the board is held, and the scene that shows it."""

from dataclasses import replace

import mujoco
import numpy as np

from boom_mj.cameras.dressing import add_board, add_cameras
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.lens import Lens
from boom_mj.cameras.studio import open_renderer
from boom_mj.cameras.view import View
from boom_mj.machine.rig import Chequerboard

Array = np.ndarray
SQUARE_TEXELS = 60
TILT = np.radians(38)
BOARD = "chequerboard"
PLACES = ((0.5, 0.5), (0.24, 0.27), (0.76, 0.27), (0.24, 0.73), (0.76, 0.73), (0.5, 0.25), (0.5, 0.75))
VIEWS = 21


def object_points(board: Chequerboard) -> Array:
    """Inner corners in the board's frame, row by row from its upper left, (n, 3), m; x right, y down, z into it."""
    columns, rows = board.corners
    grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    return np.column_stack([(grid - [(columns - 1) / 2, (rows - 1) / 2]) * board.square, np.zeros(len(grid))])


def board_picture(board: Chequerboard) -> Array:
    """Squares with a light border one square wide, (rows, columns) uint8."""
    columns, rows = board.corners[0] + 1, board.corners[1] + 1
    squares = np.full((rows + 2, columns + 2), 235, np.uint8)
    squares[1:-1, 1:-1] = np.where(np.add.outer(np.arange(rows), np.arange(columns)) % 2, 235, 20)
    return np.kron(squares, np.ones((SQUARE_TEXELS, SQUARE_TEXELS), np.uint8))


def board_poses(lens: Intrinsics, board: Chequerboard) -> list[tuple[Array, Array]]:
    """How the board is held: R_camera_board (3, 3) and place in the camera frame (3,), m, for every view.

    It fills about half the picture's width, visits the middle, the corners and the edges, and leans to all sides.
    """
    poses = []
    width = (board.corners[0] + 3) * board.square
    height = (board.corners[1] + 3) * board.square
    for k in range(VIEWS):
        u, v = PLACES[k % len(PLACES)]
        share = 0.46 if k < len(PLACES) else 0.4
        near = max(width * lens.focal[0] / (share * lens.width), height * lens.focal[1] / (1.1 * share * lens.height))
        lean, turn = 10 * np.pi * k / VIEWS, 0.25 * np.sin(2.0 * k)
        axis = (TILT if k else 0.0) * np.array([np.cos(lean), np.sin(lean), 0.0])
        rotation = _rotation(axis) @ _rotation(np.array([0, 0, turn]))
        ray = lens.rays(np.array([u * lens.width, v * lens.height]))
        poses.append((rotation, near * np.array([*ray, 1.0])))
    return poses


def shoot_boards(lens: Intrinsics, board: Chequerboard) -> list[Array]:
    """Pictures of the board in all its poses, (h, w, 3) uint8, red green blue."""
    optics = Lens(lens)
    model = _scene(optics.source, board)
    data, pictures = mujoco.MjData(model), []
    with open_renderer(model, optics.source) as renderer:
        for rotation, place in board_poses(lens, board):
            data.mocap_pos[0] = place
            mujoco.mju_mat2Quat(data.mocap_quat[0], (rotation @ np.diag([1.0, -1.0, -1.0])).ravel())
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, "camera")
            pictures.append(optics.picture(renderer.render()))
    return pictures


def _scene(source: Intrinsics, board: Chequerboard) -> mujoco.MjModel:
    """A board before a grey sky; the world is the camera frame."""
    spec = mujoco.MjSpec()
    spec.stat.extent, spec.visual.map.znear, spec.visual.map.zfar = 10.0, 0.01, 10
    spec.visual.headlight.ambient, spec.visual.headlight.diffuse = [0.55] * 3, [0.4] * 3
    spec.visual.headlight.specular = [0.0] * 3
    sky = spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT
    )
    sky.rgb1, sky.width, sky.height = [0.6, 0.62, 0.65], 16, 16
    body = spec.worldbody.add_body(name=BOARD, mocap=True)
    size = (board.corners[0] + 3) * board.square, (board.corners[1] + 3) * board.square
    add_board(spec, body, BOARD, size, board_picture(board))
    add_cameras(spec, {"camera": View(replace(source), np.eye(3), np.zeros(3))})
    return spec.compile()


def _rotation(vector: Array) -> Array:
    quaternion, matrix, angle = np.zeros(4), np.zeros(9), float(np.linalg.norm(vector))
    mujoco.mju_axisAngle2Quat(quaternion, vector / angle if angle else np.array([1.0, 0, 0]), angle)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
