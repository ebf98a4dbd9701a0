// Prints as fast as the line takes it, and much more than the buffer holds.
void setup() {
  Serial.begin(115200);
}

void loop() {
  static unsigned long line = 0;
  Serial.print(F("line "));
  Serial.print(line++);
  Serial.println(F(" of a long report that never ends"));
}
