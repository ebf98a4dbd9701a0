// Does what a test asks over the UART, a letter at a time, at 9600 baud (-DBAUD_UBRR), 8N1. ATmega328P at 16 MHz.
//
//   A n      measures on ADC channel '0' + n, answers with two bytes, low first
//   M l r    duty of the motors from -127 to 127: PWM on 9 and 10, direction on 8 and 7
//   E        coasts: both PWM pins low (a driver that coasts then lets the motors roll)
//   C        counts of INT0 (pin 2) and INT1 (pin 3), each edge, two bytes each
//   P        a PING))) on pin 4: the echo in units of 4 µs, two bytes
//   W        the level of pin 5 with its pull-up, '0' or '1'
//   K b      keeps a byte in the EEPROM; R reads it
//   V w v    pulses for servos on 11 and 12, of 4 µs times w and v, once
//   anything else comes back as it is

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/delay.h>

#ifndef BAUD_UBRR
#define BAUD_UBRR 103
#endif

static volatile uint16_t counts[2];

ISR(INT0_vect) { counts[0]++; }
ISR(INT1_vect) { counts[1]++; }

static uint8_t get(void) {
  while (!(UCSR0A & (1 << RXC0)));
  return UDR0;
}

static void put(uint8_t byte) {
  while (!(UCSR0A & (1 << UDRE0)));
  UDR0 = byte;
}

static void put16(uint16_t word) {
  put(word);
  put(word >> 8);
}

static uint16_t measure(uint8_t channel) {
  ADMUX = (1 << REFS0) | channel;
  ADCSRA |= 1 << ADSC;
  while (ADCSRA & (1 << ADSC));
  return ADC;
}

static void drive(int8_t left, int8_t right) {
  if (left < 0) PORTB &= ~(1 << PB0); else PORTB |= 1 << PB0;
  if (right < 0) PORTD &= ~(1 << PD7); else PORTD |= 1 << PD7;
  OCR1A = 2 * (left < 0 ? -left : left);
  OCR1B = 2 * (right < 0 ? -right : right);
  TCCR1A = (left ? 1 << COM1A1 : 0) | (right ? 1 << COM1B1 : 0) | (1 << WGM10);
}

static uint16_t ping(void) {
  DDRD |= 1 << PD4;
  PORTD |= 1 << PD4;
  _delay_us(5);
  PORTD &= ~(1 << PD4);
  DDRD &= ~(1 << PD4);
  uint16_t length = 0;
  while (!(PIND & (1 << PD4)));
  TCCR2B = 1 << CS22;
  TCNT2 = 0;
  TIFR2 = 1 << TOV2;
  while (PIND & (1 << PD4)) {
    if (TIFR2 & (1 << TOV2)) {
      TIFR2 = 1 << TOV2;
      length += 256;
    }
  }
  return length + TCNT2;
}

static void pulse(uint8_t bit, uint16_t units) {
  PORTB |= 1 << bit;
  while (units--) _delay_us(3.4);
  PORTB &= ~(1 << bit);
}

int main(void) {
  UBRR0 = BAUD_UBRR;
  UCSR0B = (1 << RXEN0) | (1 << TXEN0);
  DDRB |= (1 << PB0) | (1 << PB1) | (1 << PB2) | (1 << PB3) | (1 << PB4);
  DDRD |= 1 << PD7;
  PORTD |= 1 << PD5;
  TCCR1A = 1 << WGM10;
  TCCR1B = (1 << WGM12) | (1 << CS11);
  ADCSRA = (1 << ADEN) | 7;
  EICRA = (1 << ISC00) | (1 << ISC10);
  EIMSK = (1 << INT0) | (1 << INT1);
  sei();
  for (;;) {
    uint8_t command = get(), first;
    switch (command) {
      case 'A': put16(measure(get() & 7)); break;
      case 'M': first = get(); drive(first, get()); break;
      case 'E': drive(0, 0); break;
      case 'C': put16(counts[0]); put16(counts[1]); break;
      case 'P': put16(ping()); break;
      case 'W': put(PIND & (1 << PD5) ? '1' : '0'); break;
      case 'K': eeprom_write_byte((uint8_t *)7, get()); break;
      case 'R': put(eeprom_read_byte((uint8_t *)7)); break;
      case 'V': first = get(); pulse(PB3, first); pulse(PB4, get()); break;
      default: put(command);
    }
  }
}
