// An edge at pin 12, and then what micros() and millis() were just before it: every 37 ms, busy with millis() in between.
void setup() {
  Serial.begin(115200);
  pinMode(12, OUTPUT);
}

void loop() {
  static unsigned long next = 10;
  static bool high = false;
  if (millis() < next) {
    return;
  }
  next += 37;
  high = !high;
  unsigned long us = micros();
  digitalWrite(12, high);
  unsigned long ms = millis();
  Serial.print(us);
  Serial.print(' ');
  Serial.println(ms);
}
