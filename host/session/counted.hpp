// SPDX-License-Identifier: GPL-2.0-or-later
// What a session and its steppers count on the host: one list each makes the fields, the status and the summary.
#pragma once

#include <cstdint>

namespace haptable {

/// X(name) for what becomes of the states that a device, or another, sends.
#define HAPTABLE_STATE_COUNTERS(X)                                                        \
    X(lost_states)          /* gaps in the device's numbering */                          \
    X(repeated_states)      /* asked again by the device: the same answer given */        \
    X(foreign_states)       /* meant for other tables: not answered */                    \
    X(other_servo_states)   /* of a device that belongs to another servo: not answered */ \
    X(other_device_states)  /* while another device has the servo: told so */             \
    X(odd_states)           /* without a mode, a session or a number */                   \
    X(poseless_states)      /* of a tool, whose hand_pose had not come: not answered */   \
    X(old_states)           /* overtaken, or a second one with a number */                \
    X(stopped_states)       /* whose time had not run: as if none had come */             \
    X(late_states)          /* that waited 20 ms for the servo: as if none had come */    \
    X(skipped_states)       /* that waited behind a newer one */                          \
    X(absent_finger_states) /* of a second finger, which the scene has not: not answered */

/// X(name) for every counter of the servo's side of the link, beside these and the firmware's own.
#define HAPTABLE_LINK_COUNTERS(X) X(late_ticks) /* answers that took longer than a tick */

/// X(name) for every counter of a line to a target.
#define HAPTABLE_LINE_COUNTERS(X)                                             \
    X(ticks)           /* forces that answered a state */                     \
    X(contact_ticks)   /* of these, with contact */                           \
    X(resent_frames)   /* states sent again because no answer came */         \
    X(lost_answers)    /* states that the device's next one overtook */       \
    X(stale_answers)   /* to a state that was answered or overtaken before */ \
    X(skipped_bytes)   /* of the line, that belonged to no frame */           \
    X(foreign_frames)  /* whole, but not forces */                            \
    X(rejected_forces) /* that no servo of these tables gives: not published */

#define HAPTABLE_COUNTED_FIELD(name) std::int64_t name = 0;
#define HAPTABLE_COUNTED_VISIT(name) visit(#name, name);

struct StateCounters {
    HAPTABLE_STATE_COUNTERS(HAPTABLE_COUNTED_FIELD)

    /// visit(name, value) for each.
    template <typename Visit>
    void each(Visit&& visit) const {
        HAPTABLE_STATE_COUNTERS(HAPTABLE_COUNTED_VISIT)
    }
};

struct LinkCounters : StateCounters {
    HAPTABLE_LINK_COUNTERS(HAPTABLE_COUNTED_FIELD)

    template <typename Visit>
    void each(Visit&& visit) const {
        StateCounters::each(visit);
        HAPTABLE_LINK_COUNTERS(HAPTABLE_COUNTED_VISIT)
    }
};

struct LineCounters {
    HAPTABLE_LINE_COUNTERS(HAPTABLE_COUNTED_FIELD)

    template <typename Visit>
    void each(Visit&& visit) const {
        HAPTABLE_LINE_COUNTERS(HAPTABLE_COUNTED_VISIT)
    }
};

#undef HAPTABLE_COUNTED_FIELD
#undef HAPTABLE_COUNTED_VISIT

}  // namespace haptable
