# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies and servos: libhaptable (haptable_library.h), with NumPy's arrays as its memory."""
from __future__ import annotations

import enum
import math
import os
from typing import Any, Dict, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import ffi, lib

#: What one tick gives, as an array of them has it: struct haptable_touch.
CONTACT = np.dtype([("state", np.uint32), ("faults", np.uint32), ("nodes", np.int32, 3), ("alpha", np.float32, 3),
                    ("god_object", np.float32, 3), ("force", np.float32, 3), ("nodal_forces", np.float32, (3, 3))])
assert CONTACT.itemsize == ffi.sizeof("struct haptable_touch")

#: What one tick gives of a tool: the hand's, then struct haptable_wrench's own.
WRENCH = np.dtype([*((name, *CONTACT.fields[name][:1]) for name in CONTACT.names or ()), ("torque", np.float32, 3),
                   ("position", np.float32, 3), ("turn", np.float32, 4)])
assert WRENCH.itemsize == ffi.sizeof("struct haptable_wrench")

_from_buffer, _step, _float3 = ffi.from_buffer, lib.haptable_finger_step, ffi.typeof("float[3]")
_new_touch = ffi.new_allocator(should_clear_after_alloc=False)
_touch_type, _float32 = ffi.typeof("struct haptable_touch*"), np.dtype(np.float32)
_buffer = ffi.buffer
_COUNTERS = [ffi.string(lib.haptable_library_counter_name(i)).decode() for i in range(lib.haptable_library_counters())]
# As haptable-run and servo --poke do it: from outside, slowly enough that no search is left for the next tick.
_CLEARANCE, _STEP, _DEEPEST, _HOLD, _HOLD_OF_MODES = 0.01, 2e-5, 10.0, 100, 5000


class HaptableError(Exception):
    """What the library refuses: one line that names the file and what to do."""

    __module__ = "haptable"


class State(enum.IntEnum):
    """What a tick was, of Contact.state and of the field "state" of CONTACT.

    A finger touches by coming through the surface from outside. Inside the body without having come through it, as at
    a first position there, it is FREE: lead it in from outside, a little every tick, or use Body.poke. A position that
    is not finite, or is farther from the last than the scene's max_speed lets a hand go in a tick, is REJECTED: the
    servo's counters say which (rejected_positions, implausible), and the contact goes on from the next one
    that is believed."""

    SILENT = 0  #: no position yet, or none for 20 ms: zero force
    FREE = 1  #: outside, or never came in through the surface: zero force
    CONTACT = 2  #: the god-object is on the surface
    REJECTED = 3  #: the position is none, or is not believed: zero force
    LIMITED = 4  #: contact, with less force than the body's
    FAULTED = 5  #: a fault waits to be acknowledged: zero force


def _error() -> HaptableError:
    return HaptableError(ffi.string(lib.haptable_library_error()).decode())


class Contact:
    """What one tick gave. Arrays are views of it, made when they are asked for. True while the god-object is on the
    surface."""

    __slots__ = ("_touch",)

    def __init__(self, touch: Any) -> None:
        self._touch = touch

    def _view(self, begin: int, end: int, dtype: Any) -> NDArray[Any]:
        return np.frombuffer(_buffer(self._touch), dtype, (end - begin) // 4, begin)

    def __bool__(self) -> bool:
        return self._touch.state in (2, 4)

    def __repr__(self) -> str:
        return f"<Contact {self.state.name}, nodes {self.nodes.tolist()}, force {self.force.tolist()} N>"

    @property
    def state(self) -> State:
        """The number that replay has in the field "state", by name."""
        return State(self._touch.state)

    @property
    def faults(self) -> int:
        """Bits: 1 tables, 2 force, 4 positions."""
        return int(self._touch.faults)

    @property
    def nodes(self) -> NDArray[np.int32]:
        """[3] mesh nodes of the patch that the god-object is on; -1 without contact."""
        return self._view(8, 20, np.int32)

    @property
    def alpha(self) -> NDArray[np.float32]:
        """[3] area coordinates of the god-object on that patch; 0 without contact."""
        return self._view(20, 32, np.float32)

    @property
    def god_object(self) -> NDArray[np.float32]:
        """[3] m; the finger itself without contact."""
        return self._view(32, 44, np.float32)

    @property
    def force(self) -> NDArray[np.float32]:
        """[3] N, what the user feels (equation 12), at most the scene's max_force."""
        return self._view(44, 56, np.float32)

    @property
    def nodal_forces(self) -> NDArray[np.float32]:
        """[3, 3] N on nodes[i] (equation 10), not cut."""
        return self._view(56, 92, np.float32).reshape(3, 3)


class Pose:
    """Where a body that nothing holds is in the last tick; contacts and displacements are in its frame."""

    def __init__(self, pose: Any) -> None:
        self.rest_centre = np.array(list(pose.rest_centre_m))  #: [3] m, of mass, at rest
        self.centre = np.array(list(pose.centre_m))  #: [3] m
        self.turn = np.array(list(pose.turn))  #: [4] a quaternion of length 1: w x y z
        self.velocity = np.array(list(pose.velocity_m_per_s))  #: [3] m/s
        self.spin = np.array(list(pose.spin_rad_per_s))  #: [3] rad/s, body axes
        self.on_floor: int = pose.on_floor  #: bits: points of the body that the floor carries

    def __repr__(self) -> str:
        return f"<Pose centre {self.centre.tolist()} m, turn {self.turn.tolist()}>"

    @property
    def matrix(self) -> NDArray[np.float64]:
        """[3, 3] from body to world axes."""
        w, x, y, z = self.turn
        return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])

    def to_world(self, points: ArrayLike) -> NDArray[np.float64]:
        """[..., 3] m of the body's frame, as Body.rest or a god-object, in world coordinates."""
        inside = np.asarray(points, np.float64) - self.rest_centre
        world: NDArray[np.float64] = self.centre + inside @ self.matrix.T
        return world


class Servo:
    """One finger on a body, with a state of its own; for one thread at a time. Calls release the GIL.

    >>> servo = load("build/cube").servo()
    >>> servo.step([0.0, 0.0, 1.0]).state.name
    'FREE'
    >>> servo.step([0.0, float("nan"), 1.0]).state.name
    'REJECTED'
    >>> servo.counters["rejected_positions"]
    1
    """

    def __init__(self, body: "Body") -> None:
        finger = lib.haptable_finger_new(body._object)
        if finger == ffi.NULL:
            raise _error()
        self.body = body
        self._finger = ffi.gc(finger, lib.haptable_finger_free)
        self._us = 0

    def step(self, position: ArrayLike, time: Optional[float] = None) -> Contact:
        """One tick. position: [3] m, float32 is taken as it is. time: s; otherwise 1 ms after the last tick. Raises
        ValueError for another shape, and for a time that is not finite."""
        if (type(position) is not np.ndarray or position.dtype is not _float32 or position.shape != (3,)
                or not position.flags.c_contiguous):
            position = _position(position)
        touch = _new_touch(_touch_type)
        us = self._us if time is None else _microseconds(time)
        _step(self._finger, _from_buffer(_float3, position), us, touch)
        self._us = (us + 1000) & 0xFFFFFFFF
        return Contact(touch)

    def replay(self, positions: ArrayLike, out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """One tick a row, one a millisecond. positions: [n, 3] m. Returns [n] of dtype CONTACT, or fills `out`. Raises
        ValueError for other shapes.

        >>> path = np.float32([0.015, 0.015, 0.032]) - np.outer(np.arange(60), np.float32([0, 0, 1e-4]))
        >>> felt = load("build/cube").servo().replay(path)
        >>> felt["force"].shape, int(felt["state"][-1])
        ((60, 3), 2)
        >>> bool(felt["state"][-1] == State.CONTACT)
        True
        """
        x = np.ascontiguousarray(positions, np.float32)
        if x.ndim != 2 or x.shape[1] != 3:
            raise ValueError(f"positions: [n, 3] in m, not {list(x.shape)}")
        if out is None:
            out = np.empty(len(x), CONTACT)
        if out.dtype != CONTACT or out.shape != (len(x),) or not out.flags.c_contiguous or not out.flags.writeable:
            raise ValueError(f"out: [{len(x)}] of dtype haptable.CONTACT, contiguous and writeable")
        lib.haptable_finger_replay(self._finger, ffi.cast("float(*)[3]", x.ctypes.data), len(x), self._us,
                                   ffi.cast("struct haptable_touch*", out.ctypes.data))
        self._us = (self._us + 1000 * len(x)) & 0xFFFFFFFF
        return out

    @property
    def pose(self) -> Optional[Pose]:
        """Where the body is, of this servo's own; None where it is held."""
        return Pose(lib.haptable_finger_pose(self._finger)) if self.body.free else None

    @property
    def swung(self) -> NDArray[np.float32]:
        """[body.modes] sqrt(kg) m: how far each mode of a body that rings has swung by the end of the last tick, of
        this servo's own. Body.deform takes it."""
        q = np.empty(self.body.modes, np.float32)
        lib.haptable_finger_swung(self._finger, ffi.cast("float*", q.ctypes.data))
        return q

    def buttons(self, grab: bool = False, acknowledge: bool = False) -> None:
        """Held down from the next tick on."""
        lib.haptable_finger_buttons(self._finger, 2 * bool(grab) + 4 * bool(acknowledge))

    @property
    def counters(self) -> Dict[str, int]:
        """What the servo has counted, by name."""
        return {name: lib.haptable_finger_counter(self._finger, i) for i, name in enumerate(_COUNTERS)}

    @property
    def energy(self) -> Dict[str, float]:
        """J: stored_j, most_stored_j, given_j, most_given_j."""
        energy = lib.haptable_finger_energy(self._finger)
        return {name: getattr(energy, name) for name in ("stored_j", "most_stored_j", "given_j", "most_given_j")}


class Fingers:
    """All fingers of a body whose scene has [contact] fingers = 2 to 8: each feels the dents that the others make. For
    one thread at a time. Calls release the GIL. The displacements of all are Body.deform of each contact, added."""

    def __init__(self, body: "Body") -> None:
        fingers = lib.haptable_fingers_new(body._object)
        if fingers == ffi.NULL:
            raise _error()
        self.body = body
        self._fingers = ffi.gc(fingers, lib.haptable_fingers_free)
        self._us = 0

    def step(self, *position: Optional[ArrayLike], time: Optional[float] = None) -> Tuple[Contact, ...]:
        """One tick of all. position: of each finger, [3] m; None: that finger is away, and one that is left alone
        feels what it would alone. time: s; otherwise 1 ms after the last tick. Raises ValueError as Servo.step does."""
        if len(position) != self.body.fingers:
            raise ValueError(f"positions: of each of the {self.body.fingers} fingers, not of {len(position)}")
        each = [ffi.NULL if x is None else _from_buffer(_float3, _position(x)) for x in position]
        touch = ffi.new("struct haptable_touch[]", len(each))
        us = self._us if time is None else _microseconds(time)
        lib.haptable_fingers_step(self._fingers, ffi.new("float*[]", each), us, touch)
        self._us = (us + 1000) & 0xFFFFFFFF
        return tuple(_contact_of(one) for one in touch)

    def replay(self, *path: ArrayLike) -> NDArray[Any]:
        """One tick a row, one a millisecond. path: of each finger, [n, 3] m. Returns [n, fingers] of dtype CONTACT."""
        each = [np.asarray(x, np.float32) for x in path]
        if len(each) != self.body.fingers or len({x.shape for x in each}) != 1 or each[0].shape[1:] != (3,):
            raise ValueError(f"positions: [n, 3] in m of each finger, not {[list(x.shape) for x in each]}")
        x = np.ascontiguousarray(np.stack(each, 1))
        out = np.empty(x.shape[:2], CONTACT)
        lib.haptable_fingers_replay(self._fingers, ffi.cast("float(*)[3]", x.ctypes.data), len(x), self._us,
                                    ffi.cast("struct haptable_touch*", out.ctypes.data))
        self._us = (self._us + 1000 * len(x)) & 0xFFFFFFFF
        return out

    @property
    def pose(self) -> Optional[Pose]:
        """Where the body is, of these fingers' own; None where it is held."""
        return Pose(lib.haptable_fingers_pose(self._fingers)) if self.body.free else None

    @property
    def swung(self) -> NDArray[np.float32]:
        """[body.modes] as Servo.swung; Body.deform takes it with one of the contacts, and zeros with the others."""
        q = np.zeros(self.body.modes, np.float32)
        lib.haptable_fingers_swung(self._fingers, ffi.cast("float*", q.ctypes.data))
        return q

    def buttons(self, finger: int, grab: bool = False, acknowledge: bool = False) -> None:
        """Held down from the next tick on by a finger, 0 the first. Raises IndexError for one that there is not."""
        lib.haptable_fingers_buttons(self._fingers, self._finger(finger), 2 * bool(grab) + 4 * bool(acknowledge))

    def counters(self, finger: int) -> Dict[str, int]:
        """What the servo has counted of a finger, by name. Raises IndexError for one that there is not."""
        finger = self._finger(finger)
        return {name: lib.haptable_fingers_counter(self._fingers, finger, i) for i, name in enumerate(_COUNTERS)}

    def energy(self, finger: int) -> Dict[str, float]:
        """J, of a finger: stored_j, most_stored_j, given_j, most_given_j. Raises IndexError for one that there is not."""
        energy = lib.haptable_fingers_energy(self._fingers, self._finger(finger))
        return {name: getattr(energy, name) for name in ("stored_j", "most_stored_j", "given_j", "most_given_j")}

    def _finger(self, number: int) -> int:
        if number not in range(self.body.fingers):
            raise IndexError(f"finger: 0 to {self.body.fingers - 1}, not {number}")
        return int(number)


class Tool:
    """The tool of a scene with [tool], held by one hand, with a state of its own; for one thread at a time. Calls
    release the GIL. The displacements under it are Body.deform of each of `points`, added."""

    def __init__(self, body: "Body") -> None:
        held = lib.haptable_held_new(body._object)
        if held == ffi.NULL:
            raise _error()
        self.body = body
        self._held = ffi.gc(held, lib.haptable_held_free)
        self._us = 0

    def step(self, position: ArrayLike, turn: ArrayLike = (1.0, 0.0, 0.0, 0.0),
             time: Optional[float] = None) -> np.void:
        """One tick. position: [3] m of the handle; turn: [4] a quaternion w x y z of length 1, from the tool's axes to
        the world's; time as Servo.step. Returns an element of dtype WRENCH. Raises ValueError for other shapes."""
        us = self._us if time is None else _microseconds(time)
        return self._replay(np.reshape(position, (1, -1)), np.reshape(turn, (1, -1)), us)[0]

    def replay(self, positions: ArrayLike, turns: ArrayLike) -> NDArray[Any]:
        """One tick a row, one a millisecond. positions: [n, 3] m, turns: [n, 4]. Returns [n] of dtype WRENCH. Raises
        ValueError for other shapes."""
        return self._replay(positions, turns, self._us)

    def _replay(self, positions: ArrayLike, turns: ArrayLike, us: int) -> NDArray[Any]:
        x, q = np.ascontiguousarray(positions, np.float32), np.ascontiguousarray(turns, np.float32)
        if x.ndim != 2 or x.shape[1] != 3 or q.shape != (len(x), 4):
            raise ValueError(f"positions: [n, 3] in m, turns: [n, 4], not {list(x.shape)} and {list(q.shape)}")
        out = np.empty(len(x), WRENCH)
        lib.haptable_held_replay(self._held, ffi.cast("float(*)[3]", x.ctypes.data),
                                 ffi.cast("float(*)[4]", q.ctypes.data), len(x), us,
                                 ffi.cast("struct haptable_wrench*", out.ctypes.data))
        self._us = (us + 1000 * len(x)) & 0xFFFFFFFF
        return out

    @property
    def points(self) -> NDArray[Any]:
        """[body.points] of dtype CONTACT: each point's contact in the last tick."""
        out = np.empty(self.body.points, CONTACT)
        touches = ffi.cast("struct haptable_touch*", out.ctypes.data)
        for i in range(len(out)):
            if lib.haptable_held_point(self._held, i, touches + i) != 0:
                raise _error()
        return out

    def buttons(self, grab: bool = False, acknowledge: bool = False) -> None:
        """Held down from the next tick on."""
        lib.haptable_held_buttons(self._held, 2 * bool(grab) + 4 * bool(acknowledge))

    @property
    def counters(self) -> Dict[str, int]:
        """What the servo has counted, by name."""
        return {name: lib.haptable_held_counter(self._held, i) for i, name in enumerate(_COUNTERS)}


class Body:
    """The tables of a scene; any number of servos may touch it. Arrays are views of the library's memory, read-only.

    >>> body = load("build/cube")
    >>> body.name, body.rest.shape[1], body.patches.dtype.name
    ('cube', 3, 'int32')
    """

    def __init__(self, handle: Any) -> None:
        self._object = handle
        facts = lib.haptable_object_describe(handle)
        self.name: str = ffi.string(facts.name).decode()
        self.tables_hash: str = f"{facts.tables_hash:016x}"
        self.max_force: float = facts.max_force_n  #: N
        self.fingers: int = lib.haptable_object_fingers(handle)  #: of its scene: 1 to 8
        self.free: bool = lib.haptable_object_is_free(handle) != 0  #: nothing holds it: positions are the world's
        self.points: int = lib.haptable_object_points(handle)  #: of its scene's tool; 0: it has none
        self.modes: int = lib.haptable_object_modes(handle)  #: by which it rings; 0: it follows at once
        self.stiffness: float = facts.stiffness_n_per_m  #: N/m, the largest of any point, as felt
        self.rest: NDArray[np.float64] = self._array(facts.rest_m, np.float64, facts.node_count, 3)  #: [N, 3] m
        self.surface: NDArray[np.int32] = self._array(facts.surface, np.int32, facts.surface_count, 3)  #: mesh nodes
        self.patches: NDArray[np.int32] = self._array(facts.patch, np.int32, facts.patch_count, 3)  #: touchable ones
        self.row_nodes: NDArray[np.int32] = self._array(facts.row_node, np.int32, facts.row_count)  #: of deform

    def _array(self, address: Any, dtype: Any, *shape: int) -> NDArray[Any]:
        count = int(np.prod(shape))
        if count == 0:
            return np.empty(shape, dtype)
        memory = _Memory(ffi.buffer(address, count * np.dtype(dtype).itemsize), self._object)
        array: NDArray[Any] = np.asarray(memory).view(dtype).reshape(shape)
        return array

    def __repr__(self) -> str:
        return f"<Body {self.name}: {len(self.rest)} nodes, {len(self.patches)} patches, tables {self.tables_hash}>"

    def servo(self) -> Servo:
        """A servo without contact."""
        return Servo(self)

    def hands(self) -> Fingers:
        """All its fingers without contact, of a scene that has two or more."""
        return Fingers(self)

    def tool(self) -> Tool:
        """The tool of its scene without contact."""
        return Tool(self)

    @property
    def tool_points(self) -> NDArray[np.float32]:
        """[points, 3] m about the handle, in the tool's axes."""
        places = np.empty((self.points, 3), np.float32)
        lib.haptable_object_tool(self._object, ffi.cast("float(*)[3]", places.ctypes.data))
        return places

    @property
    def normals(self) -> NDArray[np.float64]:
        """[N, 3] of length 1, outwards at rest: of a mesh node on the surface the mean of its patches by area;
        0 inside.

        >>> body = load("build/cube")
        >>> top = int(np.argmin(np.linalg.norm(body.rest - (0.015, 0.015, 0.03), axis=1)))
        >>> body.normals[top].round(6).tolist()
        [0.0, 0.0, 1.0]
        """
        a, b, c = (self.rest[self.surface[:, corner]] for corner in range(3))
        normals = np.zeros_like(self.rest)
        for corner in range(3):
            np.add.at(normals, self.surface[:, corner], np.cross(b - a, c - a))
        size = np.linalg.norm(normals, axis=1, keepdims=True)
        result: NDArray[np.float64] = np.divide(normals, size, out=normals, where=size > 0.0)
        return result

    def poke(self, points: ArrayLike, depth: ArrayLike, direction: Optional[ArrayLike] = None) -> NDArray[Any]:
        """What a finger feels that is pushed straight in and rests there, as servo --poke has it: from 1 cm outside at
        20 mm/s, then 0.1 s of rest (5 s of a body that rings). Each point has a servo of its own.

        points: [..., 3] m, where it goes through the surface; depth: [...] m beyond; direction: [..., 3] of any length,
        or where it is None against the normal of the surface node that is nearest. They are broadcast. Returns [...] of
        dtype CONTACT; FREE where the way meets no touchable patch. Raises ValueError for other shapes, for numbers that
        are not finite, for a depth of more than 10 m, and for a body that nothing holds, which would give way.

        >>> body = load("build/cube")
        >>> felt = body.poke((0.015, 0.015, 0.03), [1e-3, 2e-3])
        >>> felt.shape, bool(felt["force"][1, 2] > felt["force"][0, 2] > 0)
        ((2,), True)
        """
        if self.free:
            raise ValueError(f"{self.name}: nothing holds it, and a poke would push it away: use Servo.step")
        at = np.asarray(points, np.float64)
        if at.shape[-1:] != (3,):
            raise ValueError(f"points: [..., 3] in m, not {list(at.shape)}")
        if direction is None:
            nodes = np.unique(self.surface)
            normals, rest = self.normals[nodes], self.rest[nodes]
            nearest = np.array([np.argmin(np.linalg.norm(rest - x, axis=1)) for x in at.reshape(-1, 3)], int)
            inwards = -normals[nearest].reshape(at.shape)
        else:
            inwards = np.asarray(direction, np.float64)
            if inwards.shape[-1:] != (3,):
                raise ValueError(f"direction: [..., 3], not {list(inwards.shape)}")
        at, inwards, deep = np.broadcast_arrays(at, inwards, np.asarray(depth, np.float64)[..., None])
        size = np.linalg.norm(inwards, axis=-1, keepdims=True)
        if not (np.isfinite(at).all() and np.isfinite(inwards).all() and np.isfinite(deep).all() and (size > 0).all()):
            raise ValueError("points, depth, direction: finite, and a direction that has a length")
        if deep.size and deep.max() > _DEEPEST:
            raise ValueError(f"depth: {deep.max():.4g} m: at most {_DEEPEST:g}")
        felt = np.empty(at.shape[:-1], CONTACT)
        hold = _HOLD_OF_MODES if self.modes else _HOLD
        for index in np.ndindex(felt.shape):
            way = _CLEARANCE + float(deep[index][0])
            steps = max(math.ceil(way / _STEP), 1)
            share = np.minimum(np.arange(steps + hold + 1) / steps, 1.0)[:, None]
            path = at[index] + (way * share - _CLEARANCE) * (inwards[index] / size[index])
            felt[index] = self.servo().replay(path)[-1]
        return felt

    def deform(self, contact: Union[Contact, np.void], rows: Optional[Sequence[int]] = None,
               out: Optional[NDArray[np.float32]] = None,
               swung: Optional[ArrayLike] = None) -> NDArray[np.float32]:
        """Displacements [rows, 3] in m under a contact's load (equation 8): of all rows, in the order of row_nodes, or
        of those numbered in `rows`. contact: of step, or one element of what replay gives. swung: what Servo.swung was
        in that tick, of a body that rings. rows: [k] whole numbers. out: [k, 3] float32, contiguous and writeable.
        Raises ValueError for arrays of other shapes, TypeError for rows that are no whole numbers and for another kind
        of contact, HaptableError for rows that there are not, and where the tables have no columns."""
        q = np.ascontiguousarray([] if swung is None else swung, np.float32)
        if q.shape != (self.modes,):
            raise ValueError(f"swung: [{self.modes}], as Servo.swung has it")
        touch = contact._touch if isinstance(contact, Contact) else _touch_of(contact)
        chosen = None if rows is None else _rows(rows)
        count = len(self.row_nodes) if chosen is None else len(chosen)
        if out is None:
            out = np.empty((count, 3), np.float32)
        if out.dtype != np.float32 or out.shape != (count, 3) or not out.flags.c_contiguous or not out.flags.writeable:
            raise ValueError(f"out: [{count}, 3] float32, contiguous and writeable")
        row = ffi.NULL if chosen is None else ffi.cast("uint32_t*", chosen.ctypes.data)
        u = ffi.cast("float(*)[3]", out.ctypes.data)
        if lib.haptable_object_deform(self._object, touch, row, count, u) != 0:
            raise _error()
        if lib.haptable_object_swing(self._object, ffi.cast("float*", q.ctypes.data), row, count, u) != 0:
            raise _error()
        return out


class _Memory:
    """Bytes of an object for NumPy, read-only, which keep it alive."""

    def __init__(self, buffer: Any, owner: Any) -> None:
        self._owner = owner
        address = int(ffi.cast("uintptr_t", ffi.from_buffer(buffer)))
        self.__array_interface__ = {"version": 3, "shape": (len(buffer),), "typestr": "|u1", "data": (address, True)}


def _position(position: ArrayLike) -> NDArray[np.float32]:
    x = np.ascontiguousarray(position, np.float32)
    if x.shape != (3,):
        raise ValueError(f"position: [3] in m, not {list(x.shape)}")
    return x


def _microseconds(time: float) -> int:
    """Of the servo's clock, which wraps."""
    if not math.isfinite(time):
        raise ValueError(f"time: finite, in s, not {time}")
    return round(time * 1e6) & 0xFFFFFFFF


def _rows(rows: Sequence[int]) -> NDArray[np.uint32]:
    chosen = np.asarray(rows)
    if chosen.ndim != 1:
        raise ValueError(f"rows: [k] numbers of rows, not {list(chosen.shape)}")
    if len(chosen) and chosen.dtype.kind not in "iu":
        raise TypeError("rows: whole numbers")
    if len(chosen) and (chosen.min() < 0 or chosen.max() > 0xFFFFFFFF):
        raise ValueError("rows: numbers of rows, from 0")
    return np.ascontiguousarray(chosen, np.uint32)


def _contact_of(touch: Any) -> Contact:
    """A copy of its own, of one among several."""
    own = _new_touch(_touch_type)
    own[0] = touch
    return Contact(own)


def _touch_of(contact: np.void) -> Any:
    row = np.asarray(contact)
    if row.dtype != CONTACT or row.shape != ():
        raise TypeError("contact: of Servo.step, or one element of what Servo.replay gives")
    return ffi.from_buffer("struct haptable_touch*", np.ascontiguousarray(row))


def load(folder: Union[str, "os.PathLike[str]"], tables_hash: Optional[str] = None, *, precision: Optional[str] = None,
         god_object: Optional[str] = None, bare: bool = False) -> Body:
    """The folder that haptable-precompute wrote, every file checked by its hash. tables_hash: 16 hex digits of the
    tables that are wanted. Raises HaptableError, and ValueError for a tables_hash that is none.

    To compare, without other tables: precision of the servo's blocks ("float32", "float16", "int16"), god_object
    ("nearest", "least-energy"), bare: no limit, no max_force, no release. Then tables_hash is None: it is another one.

    >>> load("no/such/folder")
    Traceback (most recent call last):
      ...
    haptable.HaptableError: no/such/folder/tables.json: is not there: make the tables with haptable-precompute
    """
    try:
        wanted = int(tables_hash, 16) if tables_hash else 0
    except ValueError:
        raise ValueError(f"tables_hash: 16 hex digits, not {tables_hash!r}") from None
    if not 0 <= wanted < 2**64:
        raise ValueError(f"tables_hash: 16 hex digits, not {tables_hash!r}")
    if precision is None and god_object is None and not bare:
        handle = lib.haptable_object_load(os.fsencode(folder), wanted)
    elif wanted:
        raise ValueError("tables_hash: with precision, god_object or bare the tables are others")
    else:
        words = [ffi.NULL if word is None else ffi.new("char[]", word.encode()) for word in (precision, god_object)]
        handle = lib.haptable_object_load_as(os.fsencode(folder),
                                             ffi.new("struct haptable_object_options*", [*words, int(bare)]))
    if handle == ffi.NULL:
        raise _error()
    return Body(ffi.gc(handle, lib.haptable_object_free))
