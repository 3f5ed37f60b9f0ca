// SPDX-License-Identifier: GPL-2.0
/* The GPIO chip: inputs whose levels the player sets.  Lines know their level while the chip is unplugged. */
#include <linux/bitmap.h>
#include <linux/gpio/driver.h>
#include <linux/interrupt.h>
#include <linux/irq.h>
#include <linux/irqdomain.h>
#include <linux/platform_device.h>
#include <linux/spinlock.h>

#include "hil_tests/guest/gpio_pulse/chip.h"
#include "hil_tests/guest/gpio_pulse/gpio_pulse.h"

struct pulse_chip {
	struct gpio_chip gpio;
	DECLARE_BITMAP(rising, GPIO_PULSE_LINES);
	DECLARE_BITMAP(falling, GPIO_PULSE_LINES);
	DECLARE_BITMAP(unmasked, GPIO_PULSE_LINES);
};

static DECLARE_BITMAP(levels, GPIO_PULSE_LINES);

/*
 * Guards `plugged`, which the player's interrupt follows.  Held while interrupts are handled, so nothing that
 * those handlers call back (mask, set_type) may take it: these touch single bits atomically.
 */
static DEFINE_RAW_SPINLOCK(plug_lock);
static struct pulse_chip *plugged;

static int get(struct gpio_chip *gpio, unsigned int line)
{
	return test_bit(line, levels);
}

static int get_direction(struct gpio_chip *gpio, unsigned int line)
{
	return GPIO_LINE_DIRECTION_IN;
}

static int direction_input(struct gpio_chip *gpio, unsigned int line)
{
	return 0;
}

static void mask(struct irq_data *data)
{
	struct gpio_chip *gpio = irq_data_get_irq_chip_data(data);
	struct pulse_chip *chip = gpiochip_get_data(gpio);

	clear_bit(irqd_to_hwirq(data), chip->unmasked);
	gpiochip_disable_irq(gpio, irqd_to_hwirq(data));
}

static void unmask(struct irq_data *data)
{
	struct gpio_chip *gpio = irq_data_get_irq_chip_data(data);
	struct pulse_chip *chip = gpiochip_get_data(gpio);

	gpiochip_enable_irq(gpio, irqd_to_hwirq(data));
	set_bit(irqd_to_hwirq(data), chip->unmasked);
}

static int set_type(struct irq_data *data, unsigned int type)
{
	struct pulse_chip *chip = gpiochip_get_data(irq_data_get_irq_chip_data(data));

	if (type & ~IRQ_TYPE_EDGE_BOTH)
		return -EINVAL;
	assign_bit(irqd_to_hwirq(data), chip->rising, type & IRQ_TYPE_EDGE_RISING);
	assign_bit(irqd_to_hwirq(data), chip->falling, type & IRQ_TYPE_EDGE_FALLING);
	return 0;
}

static const struct irq_chip interrupts = {
	.name = "gpio-pulse",
	.irq_mask = mask,
	.irq_unmask = unmask,
	.irq_set_type = set_type,
	.flags = IRQCHIP_IMMUTABLE,
	GPIOCHIP_IRQ_RESOURCE_HELPERS,
};

void gpio_pulse_chip_set(u32 line, bool value)
{
	struct pulse_chip *chip;

	if (test_bit(line, levels) == value)
		return;
	assign_bit(line, levels, value);
	raw_spin_lock(&plug_lock);
	chip = plugged;
	if (chip && test_bit(line, chip->unmasked) && test_bit(line, value ? chip->rising : chip->falling))
		generic_handle_domain_irq(chip->gpio.irq.domain, line);
	raw_spin_unlock(&plug_lock);
}

static void plug(struct pulse_chip *chip)
{
	unsigned long flags;

	raw_spin_lock_irqsave(&plug_lock, flags);
	plugged = chip;
	raw_spin_unlock_irqrestore(&plug_lock, flags);
}

/* A second chip of the same label, to be taken for the first one by mistake: its lines have no edges. */
static bool is_twin(struct platform_device *device)
{
	return device->id != PLATFORM_DEVID_NONE;
}

static int probe(struct platform_device *device)
{
	struct pulse_chip *chip = devm_kzalloc(&device->dev, sizeof(*chip), GFP_KERNEL);
	struct gpio_chip *gpio;
	int error;

	if (!chip)
		return -ENOMEM;
	gpio = &chip->gpio;
	gpio->label = "gpio-pulse";
	gpio->parent = &device->dev;
	gpio->owner = THIS_MODULE;
	gpio->base = -1;
	gpio->ngpio = GPIO_PULSE_LINES;
	gpio->get = get;
	gpio->get_direction = get_direction;
	gpio->direction_input = direction_input;
	gpio_irq_chip_set_chip(&gpio->irq, &interrupts);
	gpio->irq.handler = handle_simple_irq;
	gpio->irq.default_type = IRQ_TYPE_NONE;
	error = gpiochip_add_data(gpio, chip);
	if (error)
		return error;
	platform_set_drvdata(device, chip);
	if (!is_twin(device))
		plug(chip);
	return 0;
}

static int unplug(struct platform_device *device)
{
	struct pulse_chip *chip = platform_get_drvdata(device);

	if (!is_twin(device))
		plug(NULL);
	gpiochip_remove(&chip->gpio);
	return 0;
}

static struct platform_driver driver = {
	.driver = { .name = "gpio-pulse" },
	.probe = probe,
	.remove = unplug,
};
static struct platform_device *device, *twin;

int gpio_pulse_chip_add(void)
{
	int error = platform_driver_register(&driver);

	if (error)
		return error;
	device = platform_device_register_simple("gpio-pulse", PLATFORM_DEVID_NONE, NULL, 0);
	twin = platform_device_register_simple("gpio-pulse", 1, NULL, 0);
	if (!IS_ERR(device) && !IS_ERR(twin)) {
		device_release_driver(&twin->dev); /* until a test binds it */
		return 0;
	}
	error = IS_ERR(device) ? PTR_ERR(device) : PTR_ERR(twin);
	platform_device_unregister(IS_ERR(device) ? NULL : device);
	platform_device_unregister(IS_ERR(twin) ? NULL : twin);
	platform_driver_unregister(&driver);
	return error;
}

void gpio_pulse_chip_remove(void)
{
	platform_device_unregister(twin);
	platform_device_unregister(device);
	platform_driver_unregister(&driver);
}
