// Wakes up each 10 ms, measures, drives, and sleeps again. ATmega328P at 16 MHz.

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

EMPTY_INTERRUPT(TIMER2_COMPA_vect);

int main(void) {
  DDRB = (1 << PB0) | (1 << PB1) | (1 << PB2);
  DDRD = 1 << PD7;
  PORTB = 1 << PB0;
  PORTD = 1 << PD7;
  TCCR1A = (1 << COM1A1) | (1 << COM1B1) | (1 << WGM10);
  TCCR1B = (1 << WGM12) | (1 << CS11);
  ADMUX = 1 << REFS0;
  ADCSRA = (1 << ADEN) | 7;
  // 16 MHz / 1024 / 156: 10 ms.
  TCCR2A = 1 << WGM21;
  OCR2A = 155;
  TCCR2B = (1 << CS22) | (1 << CS21) | (1 << CS20);
  TIMSK2 = 1 << OCIE2A;
  sei();
  for (;;) {
    sleep_mode();
    ADCSRA |= 1 << ADSC;
    while (ADCSRA & (1 << ADSC));
    OCR1A = 40 + (ADC >> 3);
    OCR1B = 40;
  }
}
