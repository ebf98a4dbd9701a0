// Wanders with three infrared sensors, and sends what they see at 9600 baud. ATmega328P at 16 MHz.
//
// A0, A1, A2: sensors on the left, in front, on the right. 5, 7, 8: enable, in1 and in2 of the left motor at an L298N; 6, 9, 10: of
// the right one. 13: the LED on the board.

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdint.h>

// A Sharp GP2D12 gives 1 V, 205 of 1023, at a quarter of a metre.
#define NEAR 200

static volatile uint16_t time_ms;

// Timer 2 counts milliseconds; timer 0 makes the motors' PWM.
ISR(TIMER2_COMPA_vect) { time_ms++; }

static uint16_t now_ms(void) {
  cli();
  uint16_t now = time_ms;
  sei();
  return now;
}

static uint16_t measure(uint8_t channel) {
  ADMUX = (1 << REFS0) | channel;
  ADCSRA |= 1 << ADSC;
  while (ADCSRA & (1 << ADSC));
  return ADC;
}

static void put(char c) {
  while (!(UCSR0A & (1 << UDRE0)));
  UDR0 = c;
}

static void put_number(uint16_t number, char behind) {
  char digits[5];
  uint8_t count = 0;
  do {
    digits[count++] = '0' + number % 10;
    number /= 10;
  } while (number);
  while (count) put(digits[--count]);
  put(behind);
}

static void set(volatile uint8_t *port, uint8_t bit, uint8_t high) {
  if (high) *port |= 1 << bit; else *port &= ~(1 << bit);
}

// Duty cycles out of 255, negative for backwards.
static void drive(int16_t left, int16_t right) {
  set(&PORTD, PD7, left > 0);
  set(&PORTB, PB0, left < 0);
  set(&PORTB, PB1, right > 0);
  set(&PORTB, PB2, right < 0);
  OCR0B = left < 0 ? -left : left;
  OCR0A = right < 0 ? -right : right;
}

int main(void) {
  DDRB = (1 << PB0) | (1 << PB1) | (1 << PB2) | (1 << PB5);
  DDRD = (1 << PD5) | (1 << PD6) | (1 << PD7);
  TCCR0A = (1 << COM0A1) | (1 << COM0B1) | (1 << WGM01) | (1 << WGM00);
  TCCR0B = (1 << CS01) | (1 << CS00);
  TCCR2A = 1 << WGM21;
  OCR2A = 249;
  TCCR2B = 1 << CS22;
  TIMSK2 = 1 << OCIE2A;
  ADCSRA = (1 << ADEN) | (1 << ADPS2) | (1 << ADPS1) | (1 << ADPS0);
  UBRR0 = 103;
  UCSR0B = (1 << TXEN0) | (1 << RXEN0);
  sei();

  uint16_t turn_until_ms = 0, tell_at_ms = 0;
  int16_t side = 0;
  for (;;) {
    uint16_t left = measure(0), front = measure(1), right = measure(2);
    if (left > NEAR || front > NEAR || right > NEAR) {
      if (!side) side = left > right ? -1 : 1;
      turn_until_ms = now_ms() + 100;
    }
    if ((int16_t)(now_ms() - turn_until_ms) >= 0) side = 0;
    set(&PORTB, PB5, side != 0);
    // A positive side is to the left.
    if (side) drive(-90 * side, 90 * side); else drive(120, 120);
    if ((int16_t)(now_ms() - tell_at_ms) >= 0) {
      tell_at_ms = now_ms() + 200;
      put_number(left, ' ');
      put_number(front, ' ');
      put_number(right, '\n');
    }
  }
}
