# SPDX-License-Identifier: GPL-2.0-or-later
"""Soft objects that a haptic device can touch at 1 kHz, from NumPy.

>>> import haptable, numpy
>>> body = haptable.load("build/cube")
>>> servo = body.servo()
>>> for z in numpy.linspace(0.032, 0.0261, 60):
...     contact = servo.step((0.015, 0.015, z))
>>> bool(contact), contact.nodes.shape, bool(contact.force[2] > 0.1)
(True, (3,), True)
>>> body.deform(contact).shape == (len(body.row_nodes), 3)
True

SI units: metres, newtons, joules, seconds; positions and forces are float32, as the servo has them.
"""
from ._servo import CONTACT, WRENCH, Body, Contact, Fingers, HaptableError, Pose, Servo, State, Tool, load
from ._files import LogEvent, precompute, read_csv, read_log
from ._report import report

__all__ = ["CONTACT", "WRENCH", "Body", "Contact", "Fingers", "HaptableError", "LogEvent", "Pose", "Servo", "State",
           "Tool", "load", "precompute", "read_csv", "read_log", "report"]
