/* SPDX-License-Identifier: MIT
 *
 * The god-object of Zilles and Salisbury (1995) on a closed triangle surface. A pure function of the tables, the
 * previous contact and the finger's motion: no state of its own, no drawing, no input or output.
 */
#ifndef HAPTABLE_CONTACT_H
#define HAPTABLE_CONTACT_H

#include "haptable_entry.h"
#include "haptable_model.h"

/* Where friction's god-object of the last tick would be without it; NULL where that is not known of this contact. */
const struct haptable_contact* haptable_freed_contact(const struct haptable_model* model, struct haptable_servo* servo);

/* Slides the god-object down to the nearest point of the surface around it; *steps counts on. Returns 0 when it met
 * HAPTABLE_WALK_STEPS and is not there yet.
 * before: contact holds a point of the surface. */
int haptable_contact_slide(const struct haptable_model* model, const float x_m[3], struct haptable_contact* contact,
                           int* steps);

/* The same as one that goes on at the next tick where a tick's steps do not do, and counts that: from where it was
 * then, or else from contact. */
int haptable_contact_slide_on(const struct haptable_model* model, struct haptable_servo* servo, const float x_m[3],
                              struct haptable_contact* contact, int* steps);

/* Goes on with an earlier tick's look at the finger. Where that is clear, the finger had left then, and contact ends:
 * its path from there is still to be searched. Returns what it saw, HAPTABLE_SIGHT_INSIDE where there was no such look.
 */
enum haptable_sight haptable_contact_look_on(const struct haptable_model* model, struct haptable_servo* servo);

/* With least energy: 1 where the finger is surely inside at a contact whose load is known: it presses on all patches
 * there. */
int haptable_contact_surely_presses(const struct haptable_model* model, const struct haptable_contact* contact,
                                    const float x_m[3]);

/* With least energy, of a contact on an edge or a vertex whose load is known: 1 where E falls into another patch there,
 * and then contact is the same point on that patch. Each patch that it looks at counts on *looks; at `most` it ends. */
int haptable_contact_falls(const struct haptable_model* model, const float x_m[3], int most, uint16_t* looks,
                           struct haptable_contact* contact);

/* The finger is outside, and its path up to where it is now is searched. after: no contact. */
void haptable_contact_end(struct haptable_servo* servo);

/* What a tick has seen of the finger: ends the contact where it is clear, and counts the ticks in a row that could not
 * tell. Returns 0 where the line is blocked: then contact is to begin where that enters, or to stay. */
int haptable_contact_decide(const struct haptable_model* model, struct haptable_servo* servo,
                            enum haptable_sight sight);

#endif
