# SPDX-License-Identifier: GPL-2.0-or-later
"""Bodies and servos: libhaptable (haptable_library.h), with NumPy's arrays as its memory."""
from __future__ import annotations

import os
from typing import Any, Dict, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._library import ffi, lib

#: What one tick gives, as an array of them has it: struct haptable_touch.
CONTACT = np.dtype([("state", np.uint32), ("faults", np.uint32), ("nodes", np.int32, 3), ("alpha", np.float32, 3),
                    ("god_object", np.float32, 3), ("force", np.float32, 3), ("nodal_forces", np.float32, (3, 3))])
assert CONTACT.itemsize == ffi.sizeof("struct haptable_touch")

_from_buffer, _step, _float3 = ffi.from_buffer, lib.haptable_finger_step, ffi.typeof("float[3]")
_new_touch = ffi.new_allocator(should_clear_after_alloc=False)
_touch_type, _float32 = ffi.typeof("struct haptable_touch*"), np.dtype(np.float32)
_buffer = ffi.buffer
_COUNTERS = [ffi.string(lib.haptable_library_counter_name(i)).decode() for i in range(lib.haptable_library_counters())]
_STATES = ("silent", "free", "contact", "rejected", "limited", "faulted")


class HaptableError(Exception):
    """What the library refuses: one line that names the file and what to do."""


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
        return f"<Contact {self.state}, nodes {self.nodes.tolist()}, force {self.force.tolist()} N>"

    @property
    def state(self) -> str:
        """silent, free, contact, rejected, limited or faulted."""
        return _STATES[self._touch.state]

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
    >>> servo.step([0.0, 0.0, 1.0]).state
    'free'
    >>> servo.step([0.0, float("nan"), 1.0]).state
    'rejected'
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
        """One tick. position: [3] m, float32 is taken as it is. time: s; otherwise 1 ms after the last tick."""
        if (type(position) is not np.ndarray or position.dtype is not _float32 or position.shape != (3,)
                or not position.flags.c_contiguous):
            position = _position(position)
        touch = _new_touch(_touch_type)
        us = self._us if time is None else round(time * 1e6) & 0xFFFFFFFF
        _step(self._finger, _from_buffer(_float3, position), us, touch)
        self._us = (us + 1000) & 0xFFFFFFFF
        return Contact(touch)

    def replay(self, positions: ArrayLike, out: Optional[NDArray[Any]] = None) -> NDArray[Any]:
        """One tick a row, one a millisecond. positions: [n, 3] m. Returns [n] of dtype CONTACT, or fills `out`.

        >>> path = np.float32([0.015, 0.015, 0.032]) - np.outer(np.arange(60), np.float32([0, 0, 1e-4]))
        >>> felt = load("build/cube").servo().replay(path)
        >>> felt["force"].shape, int(felt["state"][-1])
        ((60, 3), 2)
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


class Pair:
    """Two fingers on a body whose scene has [contact] fingers = 2: each feels the other's dent. For one thread at a
    time. Calls release the GIL. The displacements of both are Body.deform of each contact, added."""

    def __init__(self, body: "Body") -> None:
        fingers = lib.haptable_fingers_new(body._object)
        if fingers == ffi.NULL:
            raise _error()
        self.body = body
        self._fingers = ffi.gc(fingers, lib.haptable_fingers_free)
        self._us = 0

    def step(self, first: Optional[ArrayLike], second: Optional[ArrayLike],
             time: Optional[float] = None) -> Tuple[Contact, Contact]:
        """One tick of both. Positions: [3] m; None: that finger is away, and the other feels what it would alone.
        time: s; otherwise 1 ms after the last tick."""
        position = [ffi.NULL if x is None else _from_buffer(_float3, _position(x)) for x in (first, second)]
        touch = ffi.new("struct haptable_touch[2]")
        us = self._us if time is None else round(time * 1e6) & 0xFFFFFFFF
        lib.haptable_fingers_step(self._fingers, position[0], position[1], us, touch)
        self._us = (us + 1000) & 0xFFFFFFFF
        return _contact_of(touch[0]), _contact_of(touch[1])

    def replay(self, first: ArrayLike, second: ArrayLike) -> NDArray[Any]:
        """One tick a row, one a millisecond. Positions: [n, 3] m of each finger. Returns [n, 2] of dtype CONTACT."""
        x, y = np.ascontiguousarray(first, np.float32), np.ascontiguousarray(second, np.float32)
        if x.ndim != 2 or x.shape[1] != 3 or x.shape != y.shape:
            raise ValueError(f"positions: [n, 3] in m of each finger, not {list(x.shape)} and {list(y.shape)}")
        out = np.empty((len(x), 2), CONTACT)
        lib.haptable_fingers_replay(self._fingers, ffi.cast("float(*)[3]", x.ctypes.data),
                                    ffi.cast("float(*)[3]", y.ctypes.data), len(x), self._us,
                                    ffi.cast("struct haptable_touch(*)[2]", out.ctypes.data))
        self._us = (self._us + 1000 * len(x)) & 0xFFFFFFFF
        return out

    @property
    def pose(self) -> Optional[Pose]:
        """Where the body is, of this pair's own; None where it is held."""
        return Pose(lib.haptable_fingers_pose(self._fingers)) if self.body.free else None

    @property
    def swung(self) -> NDArray[np.float32]:
        """[body.modes] as Servo.swung; Body.deform takes it with one of the contacts, and zeros with the other."""
        q = np.zeros(self.body.modes, np.float32)
        lib.haptable_fingers_swung(self._fingers, ffi.cast("float*", q.ctypes.data))
        return q

    def buttons(self, finger: int, grab: bool = False, acknowledge: bool = False) -> None:
        """Held down from the next tick on by finger 0 or 1. Raises IndexError for another."""
        lib.haptable_fingers_buttons(self._fingers, _finger(finger), 2 * bool(grab) + 4 * bool(acknowledge))

    def counters(self, finger: int) -> Dict[str, int]:
        """What the servo has counted of finger 0 or 1, by name. Raises IndexError for another."""
        finger = _finger(finger)
        return {name: lib.haptable_fingers_counter(self._fingers, finger, i) for i, name in enumerate(_COUNTERS)}

    def energy(self, finger: int) -> Dict[str, float]:
        """J, of finger 0 or 1: stored_j, most_stored_j, given_j, most_given_j. Raises IndexError for another."""
        energy = lib.haptable_fingers_energy(self._fingers, _finger(finger))
        return {name: getattr(energy, name) for name in ("stored_j", "most_stored_j", "given_j", "most_given_j")}


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
        self.fingers: int = lib.haptable_object_fingers(handle)  #: of its scene: 1 or 2
        self.free: bool = lib.haptable_object_is_free(handle) != 0  #: nothing holds it: positions are the world's
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

    def pair(self) -> Pair:
        """Two fingers without contact, of a scene that has them."""
        return Pair(self)

    def deform(self, contact: Union[Contact, np.void], rows: Optional[Sequence[int]] = None,
               out: Optional[NDArray[np.float32]] = None,
               swung: Optional[ArrayLike] = None) -> NDArray[np.float32]:
        """Displacements [rows, 3] in m under a contact's load (equation 8): of all rows, in the order of row_nodes, or
        of those numbered in `rows`. contact: of step, or one element of what replay gives. swung: what Servo.swung was
        in that tick, of a body that rings. rows: [k] whole numbers. out: [k, 3] float32, contiguous and writeable.
        Raises ValueError for arrays of other shapes, TypeError for rows that are no whole numbers, HaptableError for
        rows that there are not, and where the tables have no columns."""
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


def _finger(number: int) -> int:
    if number not in (0, 1):
        raise IndexError(f"finger: 0 or 1, not {number}")
    return int(number)


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


def load(folder: Union[str, "os.PathLike[str]"], tables_hash: Optional[str] = None) -> Body:
    """The folder that haptable-precompute wrote, every file checked by its hash. tables_hash: 16 hex digits of the
    tables that are wanted. Raises HaptableError.

    >>> load("no/such/folder")
    Traceback (most recent call last):
      ...
    haptable._servo.HaptableError: no/such/folder/summary.json: is not there: make the tables with haptable-precompute
    """
    wanted = int(tables_hash, 16) if tables_hash else 0
    handle = lib.haptable_object_load(os.fsencode(folder), wanted)
    if handle == ffi.NULL:
        raise _error()
    return Body(ffi.gc(handle, lib.haptable_object_free))
