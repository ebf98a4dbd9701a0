// Two whiskers to ground with the pull-ups of the chip; LEDs show them, and each touch is counted once, without its bounces.
const int WHISKERS[2] = {5, 7}, LEDS[2] = {8, 12};

void setup() {
  Serial.begin(9600);
  for (int i = 0; i < 2; i++) {
    pinMode(WHISKERS[i], INPUT_PULLUP);
    pinMode(LEDS[i], OUTPUT);
  }
}

void loop() {
  static bool touched[2] = {false, false};
  static unsigned long changed[2] = {0, 0};
  static unsigned touches[2] = {0, 0};
  for (int i = 0; i < 2; i++) {
    bool now = digitalRead(WHISKERS[i]) == LOW;
    digitalWrite(LEDS[i], now);
    if (now != touched[i] && millis() - changed[i] > 20) {
      touched[i] = now;
      changed[i] = millis();
      if (now) {
        touches[i]++;
        Serial.print(i ? "right " : "left ");
        Serial.println(touches[i]);
      }
    }
  }
}
