// Emulates the bench's Uno: runs the built firmware on libsimavr, its UART on a pseudo-terminal, and reports on standard
// output the pulses on the servo pins. The lines, and the commands on standard input, stand in launcher.py.
//
//   host FIRMWARE.elf SPEED BOOT_DELAY_S
//
// The pseudo-terminal is our own and not libsimavrparts' uart_pty: that one feeds the UART from a second thread as fast
// as the host writes, and knows neither that the port was opened, which resets an Uno, nor that it was unplugged.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <simavr/avr_ioport.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_time.h>

#define CLOCK_HZ 16000000ULL
#define SLICE_CYCLES (CLOCK_HZ / 1000)            // emulated between two looks at the outside world: 1 ms
// A byte at 115200 baud in 8N1 has ten bits of 136 cycles, by the Uno's divider. simavr's UART takes eleven, a parity
// bit among them that is not sent, and loses bytes of a long stream that comes faster.
#define BYTE_CYCLES (11 * 136)
#define TIME_LINE_CYCLES (CLOCK_HZ / 100)
#define LAG_FORGIVEN_NS 20000000LL                // further behind than this, emulated time is not made up for
#define N_PINS 6
#define INPUT_SIZE 512                            // bytes held between pseudo-terminal and UART, as a USB chip does

// The servo pins by the board's order, as in servos.h.
static const struct {
  int arduino;
  char port;
  int bit;
} PINS[N_PINS] = {{9, 'B', 1}, {10, 'B', 2}, {11, 'B', 3}, {5, 'D', 5}, {6, 'D', 6}, {7, 'D', 7}};

static avr_t *avr;
static avr_irq_t *uart_in;
static uint64_t cycles_before_reset;  // simavr may begin to count again at a reset
static uint64_t counted;              // avr->cycle when last looked at
static uint64_t deaf_until;           // boot loader
static uint64_t boot_delay_cycles;
static uint64_t rise[N_PINS];
static bool high[N_PINS];
static int master = -1;
static int watch = -1;  // notes of who opens and closes the port
static bool is_open;    // somebody has it open
static uint8_t input[INPUT_SIZE];
static size_t input_length, input_done;
static bool feeding;

static uint64_t now(void) {
  if (avr->cycle < counted) cycles_before_reset += counted;
  counted = avr->cycle;
  return cycles_before_reset + avr->cycle;
}

static void quiet(avr_t *a, const int level, const char *format, va_list arguments) {
  (void)a;
  if (level == LOG_ERROR) vfprintf(stderr, format, arguments);
}

static void fail(const char *what) {
  fprintf(stderr, "firmware emulator: %s: %s\n", what, strerror(errno));
  exit(1);
}

// --- pins

static void set_pin(int pin, bool value) {
  if (value && !high[pin]) rise[pin] = now();
  if (!value && high[pin]) {
    printf("pulse %llu %d %llu\n", (unsigned long long)now(), PINS[pin].arduino, (unsigned long long)(now() - rise[pin]));
  }
  high[pin] = value;
}

static void pin_changed(avr_irq_t *irq, uint32_t value, void *pin) {
  (void)irq;
  set_pin((int)(intptr_t)pin, value & 1);
}

// --- serial port

static void open_port(void) {
  master = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (master < 0 || grantpt(master) || unlockpt(master)) fail("no pseudo-terminal");
  int slave = open(ptsname(master), O_RDWR | O_NOCTTY);
  if (slave < 0) fail(ptsname(master));
  struct termios raw;
  tcgetattr(slave, &raw);
  cfmakeraw(&raw);  // no echo before the host sets the port up
  tcsetattr(slave, TCSANOW, &raw);
  close(slave);  // from here on the kernel reports whether somebody has it open
  watch = inotify_init1(IN_NONBLOCK);
  if (watch < 0 || inotify_add_watch(watch, ptsname(master), IN_OPEN | IN_CLOSE) < 0) fail("no inotify");
  is_open = false;
  printf("port %s\n", ptsname(master));
}

static void close_port(void) {
  if (master < 0) return;
  close(master);
  close(watch);
  master = -1;
  is_open = false;
  input_length = input_done = 0;
  printf("unplugged\n");
}

static void byte_from_avr(avr_irq_t *irq, uint32_t value, void *unused) {
  (void)irq, (void)unused;
  uint8_t byte = value;
  // A host that does not read loses bytes, as on a real port.
  if (is_open && write(master, &byte, 1) < 0 && errno != EAGAIN && errno != EIO) fail("write to pseudo-terminal");
}

static avr_cycle_count_t feed(avr_t *a, avr_cycle_count_t when, void *unused) {
  (void)a, (void)unused;
  if (input_done < input_length) avr_raise_irq(uart_in, input[input_done++]);
  feeding = input_done < input_length;
  return feeding ? when + BYTE_CYCLES : 0;
}

static void press_reset(void) {
  avr_reset(avr);
  deaf_until = now() + boot_delay_cycles;
}

static void was_reset(avr_t *a) {  // by us or by the watchdog
  (void)a;
  for (int pin = 0; pin < N_PINS; pin++) set_pin(pin, false);
  printf("reset %llu\n", (unsigned long long)now());
  feeding = false;
}

static bool somebody_has_it_open(void) {
  struct pollfd look = {.fd = master, .events = POLLIN};
  if (poll(&look, 1, 0) < 0) fail("poll");
  return !(look.revents & POLLHUP);
}

// Whether the port was opened since the last look. Who closes it and opens it again at once is found in the order of
// the kernel's notes; a second program that opens and closes it beside the first leaves the opposite order.
static bool was_opened(void) {
  char notes[4096] __attribute__((aligned(8)));
  bool before = is_open, closed = false, reopened = false;
  ssize_t size = read(watch, notes, sizeof notes);
  for (char *at = notes; at < notes + size; at += sizeof(struct inotify_event) + ((struct inotify_event *)at)->len) {
    if (((struct inotify_event *)at)->mask & IN_CLOSE) closed = true;
    if (((struct inotify_event *)at)->mask & IN_OPEN) reopened = closed;
  }
  is_open = somebody_has_it_open();
  return is_open && (!before || reopened);
}

static void serve_port(void) {
  if (master < 0) return;
  if (was_opened()) press_reset();  // the USB chip pulls the reset line when the port is opened
  if (input_done == input_length) {
    ssize_t count = read(master, input, INPUT_SIZE);
    input_done = 0;
    input_length = count > 0 ? (size_t)count : 0;
  }
  if (now() < deaf_until) input_length = input_done = 0;
  if (input_done < input_length && !feeding) {
    feeding = true;
    avr_cycle_timer_register(avr, BYTE_CYCLES, feed, NULL);
  }
}

// --- commands

static bool paused;
// Emulated time goes no further than this, so that what it does is independent of how busy the machine is.
static uint64_t limit = UINT64_MAX;
static bool held_told, heard_told;

static void hold_at(uint64_t cycle) {
  limit = cycle ? cycle : UINT64_MAX;
  held_told = heard_told = false;
}

static void obey(const char *command) {
  if (!strncmp(command, "until ", 6)) hold_at(strtoull(command + 6, NULL, 10));
  if (!strcmp(command, "reset")) press_reset();
  if (!strcmp(command, "pause")) paused = true;
  if (!strcmp(command, "resume")) paused = false;
  if (!strcmp(command, "unplug")) close_port();
  if (!strcmp(command, "plug") && master < 0) open_port();
}

static void serve_commands(void) {
  static char line[64];
  static size_t length;
  char byte;
  ssize_t count;
  while ((count = read(STDIN_FILENO, &byte, 1)) == 1) {
    if (byte == '\n') {
      line[length] = 0;
      length = 0;
      obey(line);
    } else if (length < sizeof line - 1) {
      line[length++] = byte;
    }
  }
  if (count == 0) exit(0);  // whoever started us is gone
}

// --- time

static int64_t clock_ns(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return time.tv_sec * 1000000000LL + time.tv_nsec;
}

static void no_sleep(avr_t *a, avr_cycle_count_t cycles) { (void)a, (void)cycles; }

// Run to `end`, a boot loader's wait included; false if the processor has stopped for good.
static bool run_until(uint64_t end) {
  while (now() < end) {
    if (now() < deaf_until) {
      cycles_before_reset += (end < deaf_until ? end : deaf_until) - now();
      continue;
    }
    int state = avr_run(avr);
    if (state == cpu_Done || state == cpu_Crashed) return false;
  }
  return true;
}

int main(int count, char **arguments) {
  if (count != 4) {
    fprintf(stderr, "usage: host FIRMWARE.elf SPEED BOOT_DELAY_S\n");
    return 2;
  }
  double speed = atof(arguments[2]);
  boot_delay_cycles = (uint64_t)(atof(arguments[3]) * CLOCK_HZ);
  avr_global_logger_set(quiet);

  elf_firmware_t firmware = {0};
  if (elf_read_firmware(arguments[1], &firmware)) fail(arguments[1]);
  avr = avr_make_mcu_by_name("atmega328p");
  if (!avr) fail("atmega328p is unknown to simavr");
  avr_init(avr);
  avr->frequency = CLOCK_HZ;
  avr->sleep = no_sleep;  // we keep the pace ourselves
  avr_load_firmware(avr, &firmware);
  avr->frequency = CLOCK_HZ;

  uint32_t flags = 0;  // neither print what is sent nor slow down when the firmware polls
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  uart_in = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), byte_from_avr, NULL);
  for (intptr_t pin = 0; pin < N_PINS; pin++) {
    avr_irq_t *irq = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ(PINS[pin].port), IOPORT_IRQ_PIN0 + PINS[pin].bit);
    avr_irq_register_notify(irq, pin_changed, (void *)pin);
  }
  avr->reset = was_reset;
  deaf_until = boot_delay_cycles;

  fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  open_port();
  int64_t slice_ns = (int64_t)(SLICE_CYCLES * 1e9 / CLOCK_HZ / speed);
  int64_t due = clock_ns();
  uint64_t next_line = 0;
  for (;;) {
    serve_commands();
    if (!paused) {
      serve_port();
      uint64_t end = now() + SLICE_CYCLES;
      if (now() < limit && !run_until(end < limit ? end : limit)) fail("the processor stopped");
      if (now() >= limit && !held_told) {
        printf("held %llu\n", (unsigned long long)now());
        held_told = true;
      }
      if (held_told && !heard_told && input_done < input_length) {
        printf("heard\n");
        heard_told = true;
      }
      if (now() >= next_line) {
        printf("time %llu\n", (unsigned long long)now());
        next_line = now() + TIME_LINE_CYCLES;
      }
    }
    fflush(stdout);
    due += slice_ns;
    if (clock_ns() > due + LAG_FORGIVEN_NS) due = clock_ns();
    struct timespec until = {.tv_sec = due / 1000000000LL, .tv_nsec = due % 1000000000LL};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
  }
}
