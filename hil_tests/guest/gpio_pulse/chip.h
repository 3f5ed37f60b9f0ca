/* SPDX-License-Identifier: GPL-2.0 */
#ifndef GPIO_PULSE_CHIP_H
#define GPIO_PULSE_CHIP_H

#include <linux/types.h>

int gpio_pulse_chip_add(void);
void gpio_pulse_chip_remove(void);

/* Sets a level; an edge interrupts whoever asked for it.  In hard interrupt context only. */
void gpio_pulse_chip_set(u32 line, bool value);

#endif
