// All inputs of the ADC, ten times a second, as a table.
void setup() {
  Serial.begin(9600);
}

void loop() {
  for (uint8_t input = A0; input <= A5; input++) {
    Serial.print(analogRead(input));
    Serial.print(input == A5 ? '\n' : '\t');
  }
  delay(100);
}
