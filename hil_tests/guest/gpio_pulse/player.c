// SPDX-License-Identifier: GPL-2.0
/* The player: a queue of steps from user space, played by a timer in hard interrupt context. */
#include <linux/fs.h>
#include <linux/hrtimer.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/mutex.h>
#include <linux/poll.h>
#include <linux/spinlock.h>
#include <linux/uaccess.h>
#include <linux/vmalloc.h>
#include <linux/wait.h>

#include "hil_tests/guest/gpio_pulse/chip.h"
#include "hil_tests/guest/gpio_pulse/gpio_pulse.h"

/* Waking a waiting program at every edge would cost more than the edge: done when there is time, or at times. */
#define STEPS_PER_WAKE 1024
#define PAUSE_NS NSEC_PER_MSEC
#define STEPS_PER_COPY 256

/*
 * One ring: its steps are read, then played, then queued ones; read <= played <= written.  `played` belongs to
 * the timer, `written` and `read` to the file's functions, each under its mutex; `lock` guards the timer's
 * sleep: it is idle exactly if played == written.
 */
static struct gpio_pulse_step *ring;
static u64 written, played, read_out;
static u64 last_ns;
static bool keeps_truth;
static DEFINE_RAW_SPINLOCK(lock);
static DEFINE_MUTEX(write_mutex);
static DEFINE_MUTEX(read_mutex);
static DECLARE_WAIT_QUEUE_HEAD(progress);
static struct hrtimer timer;
static atomic_t is_open = ATOMIC_INIT(0);

static struct gpio_pulse_step *slot(u64 number)
{
	return &ring[number % GPIO_PULSE_QUEUE];
}

static u64 room(void)
{
	return GPIO_PULSE_QUEUE - (READ_ONCE(written) - (keeps_truth ? READ_ONCE(read_out) : READ_ONCE(played)));
}

static bool is_idle(void)
{
	return READ_ONCE(played) == READ_ONCE(written);
}

static enum hrtimer_restart play(struct hrtimer *t)
{
	enum hrtimer_restart again = HRTIMER_NORESTART;
	bool wake = false;

	raw_spin_lock(&lock);
	while (played != written) {
		struct gpio_pulse_step *step = slot(played);
		u64 now = ktime_get_ns();

		if (step->t_ns > now) {
			hrtimer_set_expires(t, ns_to_ktime(step->t_ns));
			again = HRTIMER_RESTART;
			wake |= step->t_ns - now > PAUSE_NS;
			break;
		}
		step->t_ns = now;
		gpio_pulse_chip_set(step->line, step->value);
		/* The reader must not see a place before its truth. */
		smp_store_release(&played, played + 1);
		wake |= played % STEPS_PER_WAKE == 0;
	}
	wake |= again == HRTIMER_NORESTART;
	raw_spin_unlock(&lock);
	if (wake)
		wake_up_interruptible(&progress);
	return again;
}

/* A line that the player before left high would swallow the first edge of this one. */
static void take_lines_low(void)
{
	unsigned long flags;
	u32 line;

	for (line = 0; line < GPIO_PULSE_LINES; line++) {
		local_irq_save(flags);
		gpio_pulse_chip_set(line, false);
		local_irq_restore(flags);
	}
}

static int open(struct inode *inode, struct file *file)
{
	if (atomic_cmpxchg(&is_open, 0, 1) != 0)
		return -EBUSY;
	written = played = read_out = last_ns = 0;
	keeps_truth = file->f_mode & FMODE_READ;
	take_lines_low();
	return nonseekable_open(inode, file);
}

static int release(struct inode *inode, struct file *file)
{
	hrtimer_cancel(&timer);
	atomic_set(&is_open, 0);
	return 0;
}

/* Copies steps into free places, which the timer does not look at yet. */
static int accept(const char __user *from, u64 count)
{
	u64 last = last_ns, k;

	for (k = 0; k < count; k++) {
		struct gpio_pulse_step *step = slot(written + k);

		if (copy_from_user(step, from + k * sizeof(*step), sizeof(*step)))
			return -EFAULT;
		if (step->line >= GPIO_PULSE_LINES || step->value > 1 || step->t_ns < last)
			return -EINVAL;
		last = step->t_ns;
	}
	last_ns = last;
	return 0;
}

static void queue(u64 count)
{
	unsigned long flags;
	bool was_idle;

	raw_spin_lock_irqsave(&lock, flags);
	was_idle = played == written;
	written += count;
	raw_spin_unlock_irqrestore(&lock, flags);
	if (was_idle)
		hrtimer_start(&timer, ns_to_ktime(slot(written - count)->t_ns), HRTIMER_MODE_ABS_HARD);
}

static ssize_t wait_for_room(struct file *file)
{
	if (room())
		return 0;
	if (file->f_flags & O_NONBLOCK)
		return -EAGAIN;
	if (wait_event_interruptible(progress, room() || (keeps_truth && is_idle())))
		return -ERESTARTSYS;
	return room() ? 0 : -ENOBUFS;
}

static ssize_t write(struct file *file, const char __user *from, size_t size, loff_t *offset)
{
	ssize_t error = 0;
	size_t done = 0;

	if (!size || size % sizeof(struct gpio_pulse_step))
		return -EINVAL;
	if (mutex_lock_interruptible(&write_mutex))
		return -ERESTARTSYS;
	while (done < size) {
		u64 count;

		error = wait_for_room(file);
		if (error)
			break;
		count = min_t(u64, room(), (size - done) / sizeof(struct gpio_pulse_step));
		count = min_t(u64, count, STEPS_PER_COPY);
		error = accept(from + done, count);
		if (error)
			break;
		queue(count);
		done += count * sizeof(struct gpio_pulse_step);
	}
	mutex_unlock(&write_mutex);
	return done ? done : error;
}

static ssize_t read(struct file *file, char __user *to, size_t size, loff_t *offset)
{
	u64 want = size / sizeof(struct gpio_pulse_step), count, k;
	ssize_t result = -EFAULT;

	if (!want)
		return -EINVAL;
	want = min_t(u64, want, GPIO_PULSE_QUEUE / 2);
	if (mutex_lock_interruptible(&read_mutex))
		return -ERESTARTSYS;
	if (!(file->f_flags & O_NONBLOCK) &&
	    wait_event_interruptible(progress, is_idle() || smp_load_acquire(&played) - read_out >= want)) {
		result = -ERESTARTSYS;
		goto out;
	}
	count = min(want, smp_load_acquire(&played) - read_out);
	if (!count && !is_idle()) {
		result = -EAGAIN;
		goto out;
	}
	for (k = 0; k < count; k++)
		if (copy_to_user(to + k * sizeof(struct gpio_pulse_step), slot(read_out + k),
				 sizeof(struct gpio_pulse_step)))
			goto out;
	WRITE_ONCE(read_out, read_out + count);
	wake_up_interruptible(&progress);
	result = count * sizeof(struct gpio_pulse_step);
out:
	mutex_unlock(&read_mutex);
	return result;
}

static int wait_until_played(struct file *file, loff_t from, loff_t to, int datasync)
{
	return wait_event_interruptible(progress, is_idle()) ? -ERESTARTSYS : 0;
}

static __poll_t poll(struct file *file, struct poll_table_struct *table)
{
	__poll_t ready = 0;

	poll_wait(file, &progress, table);
	if (READ_ONCE(played) != READ_ONCE(read_out) && keeps_truth)
		ready |= EPOLLIN | EPOLLRDNORM;
	if (room())
		ready |= EPOLLOUT | EPOLLWRNORM;
	return ready;
}

static const struct file_operations operations = {
	.owner = THIS_MODULE,
	.open = open,
	.release = release,
	.write = write,
	.read = read,
	.fsync = wait_until_played,
	.poll = poll,
	.llseek = no_llseek,
};

static struct miscdevice player = {
	.minor = MISC_DYNAMIC_MINOR,
	.name = "gpio-pulse",
	.fops = &operations,
};

static int __init gpio_pulse_init(void)
{
	int error;

	ring = vzalloc(GPIO_PULSE_QUEUE * sizeof(*ring));
	if (!ring)
		return -ENOMEM;
	hrtimer_init(&timer, CLOCK_MONOTONIC, HRTIMER_MODE_ABS_HARD);
	timer.function = play;
	error = gpio_pulse_chip_add();
	if (error)
		goto free_ring;
	error = misc_register(&player);
	if (!error)
		return 0;
	gpio_pulse_chip_remove();
free_ring:
	vfree(ring);
	return error;
}

static void __exit gpio_pulse_exit(void)
{
	misc_deregister(&player);
	gpio_pulse_chip_remove();
	vfree(ring);
}

module_init(gpio_pulse_init);
module_exit(gpio_pulse_exit);
MODULE_DESCRIPTION("GPIO chip whose inputs are played from a list of timed levels");
MODULE_LICENSE("GPL");
