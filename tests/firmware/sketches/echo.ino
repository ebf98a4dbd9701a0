// Two numbers in, their sum and product out; every other line comes back in capitals.
void setup() {
  Serial.begin(115200);
  while (!Serial) {
  }
  Serial.setTimeout(100);
  Serial.println(F("ready"));
}

void loop() {
  if (!Serial.available()) {
    return;
  }
  int first = Serial.peek();
  if (first == '-' || isDigit(first)) {
    long a = Serial.parseInt();
    long b = Serial.parseInt();
    Serial.print(F("sum "));
    Serial.print(a + b);
    Serial.print(F(" product "));
    Serial.println(a * b);
    Serial.readStringUntil('\n');
  } else {
    String line = Serial.readStringUntil('\n');
    line.trim();
    line.toUpperCase();
    Serial.println(line);
  }
}
