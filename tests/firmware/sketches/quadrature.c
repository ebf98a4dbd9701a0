// Without a core: a quadrature encoder by pin changes of port C, and its count by printf over the USART.
#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdio.h>
#include <util/delay.h>

static volatile int16_t count;

ISR(PCINT1_vect) {
  static uint8_t last;
  // What a step adds, by the old and the new state of both channels.
  static const int8_t steps[16] = {0, 1, -1, 0, -1, 0, 0, 1, 1, 0, 0, -1, 0, -1, 1, 0};
  uint8_t now = PINC & 3;
  count += steps[last << 2 | now];
  last = now;
}

static int put(char character, FILE *stream) {
  (void)stream;
  loop_until_bit_is_set(UCSR0A, UDRE0);
  UDR0 = character;
  return 0;
}

static FILE line = FDEV_SETUP_STREAM(put, NULL, _FDEV_SETUP_WRITE);

int main(void) {
  UBRR0 = 103;
  UCSR0B = _BV(TXEN0);
  stdout = &line;
  PCMSK1 = 3;
  PCICR = _BV(PCIE1);
  sei();
  for (;;) {
    _delay_ms(250);
    cli();
    int16_t now = count;
    sei();
    printf("%d\n", now);
  }
}
