// Wanders with three infrared sensors, and sends what they see.
//
// A0, A1, A2: sensors on the left, in front, on the right. 5, 7, 8: enable, in1 and in2 of the left motor at an L298N; 6, 9, 10: of
// the right one. 13: the LED on the board.

const int LEFT[] = {5, 7, 8}, RIGHT[] = {6, 9, 10};
// A Sharp GP2D12 gives 1 V, 205 of 1023, at a quarter of a metre.
const int NEAR = 200;

unsigned long turn_until_ms = 0, tell_at_ms = 0;
int side = 1;

void motor(const int pins[], int duty) {
  digitalWrite(pins[1], duty > 0);
  digitalWrite(pins[2], duty < 0);
  analogWrite(pins[0], abs(duty));
}

void drive(int left, int right) {
  motor(LEFT, left);
  motor(RIGHT, right);
}

void setup() {
  Serial.begin(9600);
  for (int i = 0; i < 3; i++) {
    pinMode(LEFT[i], OUTPUT);
    pinMode(RIGHT[i], OUTPUT);
  }
  pinMode(LED_BUILTIN, OUTPUT);
}

void loop() {
  int left = analogRead(A0), front = analogRead(A1), right = analogRead(A2);
  unsigned long now_ms = millis();
  bool is_turning = now_ms < turn_until_ms;
  if (left > NEAR || front > NEAR || right > NEAR) {
    if (!is_turning) side = left > right ? -1 : 1;
    turn_until_ms = now_ms + 100;
    is_turning = true;
  }
  digitalWrite(LED_BUILTIN, is_turning);
  // A positive side is to the left.
  if (is_turning) drive(-90 * side, 90 * side); else drive(120, 120);
  if (now_ms >= tell_at_ms) {
    tell_at_ms = now_ms + 200;
    Serial.print(left);
    Serial.print(' ');
    Serial.print(front);
    Serial.print(' ');
    Serial.println(right);
  }
}
