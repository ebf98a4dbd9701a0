// Main loops of several forms. Each round inverts PB5 once, at its beginning.

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/delay.h>

#define NESTED 1
#define ASLEEP 2
#define ARGUMENTS 3
#define FAR 4
#define FOREVER 5
#define WATCHDOG 6

#define TEN(text) text text text text text text text text text text

volatile uint8_t flag, sink;
volatile uint16_t counted;
uint8_t table[40] = {1, 2, 3};

static void mark(void) { PINB = 1 << PB5; }

// Loops of its own, at a lower stack pointer.
__attribute__((noinline)) static uint8_t sum(uint8_t count) {
  uint8_t all = 0;
  for (volatile uint8_t i = 0; i < count; i++) all += table[i % sizeof table];
  return all;
}

// Arguments beyond those in registers are pushed at the stack pointer of the main loop.
__attribute__((noinline, unused)) static uint8_t many(uint8_t count, ...) {
  __builtin_va_list values;
  __builtin_va_start(values, count);
  uint8_t all = 0;
  for (volatile uint8_t i = 0; i < count; i++) all += __builtin_va_arg(values, int) + sum(3);
  __builtin_va_end(values);
  return all;
}

// More rounds than most main loops have in a test.
__attribute__((noinline)) static void set_up(void) {
  DDRB = 1 << PB5;
  for (volatile uint16_t i = 0; i < 2000; i++) sink = sum(2);
  TCCR0A = 1 << WGM01;
  OCR0A = 249;
  TCCR0B = 1 << CS01 | 1 << CS00;
  TIMSK0 = 1 << OCIE0A;
  sei();
}

ISR(TIMER0_COMPA_vect) {
  counted++;
  flag = 1;
  for (uint8_t i = 0; i < 3; i++) sink = PINC;
}

#if PROGRAM == FOREVER
__attribute__((noinline, noreturn)) static void forever(void) {
  for (;;) {
    mark();
    sink = many(5, 1, 2, 3, 4, 5);
    for (uint8_t i = 0; i < 4; i++) sink = i;
  }
}
#endif

int main(void) {
#if PROGRAM == WATCHDOG
  MCUSR = 0;
  wdt_disable();
#endif
  // Loops of main before its main loop.
  for (volatile uint16_t i = 0; i < 500; i++) sink = i;
  set_up();
  for (volatile uint16_t i = 0; i < 300; i++) sink = sum(1);
#if PROGRAM == NESTED
  for (;;) {
    mark();
    while (!flag) sink++;
    flag = 0;
    for (uint8_t i = 0; i < 10; i++) {
      for (volatile uint8_t j = 0; j < i; j++) sink = j;
      if (sink & 2) continue;
      sink = sum(i);
    }
    if (counted & 1) continue;
    _delay_us(100);
  }
#elif PROGRAM == ASLEEP
  set_sleep_mode(SLEEP_MODE_IDLE);
  for (;;) {
    mark();
    sink = sum(5);
    sleep_mode();
  }
#elif PROGRAM == ARGUMENTS
  for (;;) {
    mark();
    sink = many(5, 1, 2, sink, 4, 5);
  }
#elif PROGRAM == FAR
  // The jump back is JMP.
  for (;;) {
    mark();
    sink = sum(4);
    __asm__ volatile(TEN(TEN(TEN("nop\n nop\n nop\n"))));
  }
#elif PROGRAM == FOREVER
  forever();
#elif PROGRAM == WATCHDOG
  wdt_enable(WDTO_60MS);
  for (;;) {
    mark();
    sink = sum(7);
  }
#endif
}
