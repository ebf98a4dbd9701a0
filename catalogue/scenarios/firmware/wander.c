// Wanders with five infrared sensors, and sends what it sees at 9600 baud. ATmega328P at 16 MHz.
//
//     avr-gcc -mmcu=atmega328p -Os -o wander.elf wander.c && avr-objcopy -O ihex wander.elf wander.hex
//
// A0 to A4: infrared sensors from left to right. 9, 8: PWM and direction of the left motor; 10, 7: of the right one. 13: LED.

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
#include <avr/interrupt.h>
#include <avr/io.h>

// From this reading on, of 1023, something is near.
#define NEAR 160
// The duty cycle of the motors, out of 255.
#define AHEAD 70
#define TURNING 40

static volatile uint16_t ticks_ms;

ISR(TIMER0_COMPA_vect) { ticks_ms++; }

static uint16_t now_ms(void) {
  cli();
  uint16_t now = ticks_ms;
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

static void put_number(uint16_t number) {
  char digits[5];
  uint8_t count = 0;
  do {
    digits[count++] = '0' + number % 10;
    number /= 10;
  } while (number);
  while (count) put(digits[--count]);
}

// Duty cycles, negative for backwards.
static void drive(int16_t left, int16_t right) {
  if (left < 0) PORTB &= ~(1 << PB0); else PORTB |= 1 << PB0;
  if (right < 0) PORTD &= ~(1 << PD7); else PORTD |= 1 << PD7;
  OCR1A = left < 0 ? -left : left;
  OCR1B = right < 0 ? -right : right;
}

int main(void) {
  // A tick of a millisecond.
  TCCR0A = 1 << WGM01;
  OCR0A = 249;
  TCCR0B = (1 << CS01) | (1 << CS00);
  TIMSK0 = 1 << OCIE0A;
  // PWM at 7.8 kHz on 9 and 10.
  DDRB |= (1 << PB0) | (1 << PB1) | (1 << PB2) | (1 << PB5);
  DDRD |= 1 << PD7;
  TCCR1A = (1 << COM1A1) | (1 << COM1B1) | (1 << WGM10);
  TCCR1B = (1 << WGM12) | (1 << CS11);
  ADCSRA = (1 << ADEN) | (1 << ADPS2) | (1 << ADPS1) | (1 << ADPS0);
  UBRR0 = 103;
  UCSR0B = (1 << TXEN0) | (1 << RXEN0);
  sei();

  uint16_t next_ms = 0, until_ms = 0, told_ms = 0;
  int8_t side = 0;
  for (;;) {
    while ((int16_t)(now_ms() - next_ms) < 0);
    next_ms += 20;
    uint16_t seen[5];
    for (uint8_t i = 0; i < 5; i++) seen[i] = measure(i);
    uint16_t left = seen[0] > seen[1] ? seen[0] : seen[1];
    uint16_t right = seen[4] > seen[3] ? seen[4] : seen[3];
    uint8_t near = left > NEAR || right > NEAR || seen[2] > NEAR;
    if (near) {
      if (!side) side = left > right ? -1 : 1;
      until_ms = now_ms() + 200;
      PORTB |= 1 << PB5;
    }
    if (side && (int16_t)(now_ms() - until_ms) < 0) {
      drive(side < 0 ? TURNING : -TURNING, side < 0 ? -TURNING : TURNING);
    } else {
      side = 0;
      PORTB &= ~(1 << PB5);
      drive(AHEAD, AHEAD);
    }
    if ((uint16_t)(now_ms() - told_ms) >= 100) {
      told_ms = now_ms();
      for (uint8_t i = 0; i < 5; i++) {
        put_number(seen[i]);
        put(i < 4 ? ' ' : '\n');
      }
    }
  }
}
