/* SPDX-License-Identifier: GPL-2.0 */
/*
 * Interface between programs and the module gpio-pulse.
 *
 * /dev/gpio-pulse is a player of levels for the GPIO chip "gpio-pulse".  One program at a time may open it, and
 * finds all lines low.
 *
 * write  queues whole gpio_pulse_steps; their times must not decrease, ever (EINVAL).  A time that has passed
 *        plays at once.  Blocks while the queue is full.  Opened for reading too, a step keeps its place until
 *        its edge was read: if only reading could make room, write fails with ENOBUFS.
 * read   the levels that were played, in order, with the time they were: the truth.  Blocks until the buffer
 *        is full or all that was queued has been played; 0 if there is nothing more.
 * fsync  returns when all has been played.
 * close  forgets what has not been played; lines keep their levels.
 *
 * The chip goes and comes as the kernel removes and adds any device, while the player plays on:
 *
 *     echo gpio-pulse > /sys/bus/platform/drivers/gpio-pulse/unbind      (and bind)
 */
#ifndef GPIO_PULSE_H
#define GPIO_PULSE_H

#include <linux/types.h>

enum { GPIO_PULSE_LINES = 32, GPIO_PULSE_QUEUE = 1 << 18 };

struct gpio_pulse_step {
	__u64 t_ns; /* CLOCK_MONOTONIC */
	__u32 line;
	__u32 value; /* 0 or 1; the same as before is no edge */
};

#endif
