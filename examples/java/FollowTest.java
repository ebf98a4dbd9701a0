import static org.junit.jupiter.api.Assertions.assertEquals;
import static org.junit.jupiter.api.Assertions.assertTrue;

import baudbot.v1.*;
import java.util.HashMap;
import java.util.List;
import java.util.Map;
import java.util.concurrent.CopyOnWriteArrayList;
import org.junit.jupiter.api.Test;

final class FollowTest {
    private static Command step(Map<String, Double> readings) {
        return Follow.step(readings::getOrDefault);
    }

    private static Command signals(double left, double right) {
        return Command.newBuilder().setLeftSignal(left).setRightSignal(right).build();
    }

    @Test
    void turnsOnTheSpotUntilReadingsArrive() {
        assertEquals(signals(-0.2, 0.2), step(Map.of()));
    }

    @Test
    void turnsLeftOnTheSpotInACorner() {
        assertEquals(signals(-0.2, 0.2), step(Map.of("ir_front", 0.1, "ir_front_left", 0.5, "ir_right", 0.3)));
    }

    @Test
    void drivesStraightAtTheWantedNearness() {
        assertEquals(signals(0.4, 0.4), step(Map.of("ir_front", 0.0, "ir_front_left", 0.0, "ir_right", Follow.WANTED)));
    }

    @Test
    void turnsAwayFromAWallThatIsTooNear() {
        var command = step(Map.of("ir_front", 0.0, "ir_front_left", 0.0, "ir_front_right", 0.8));
        assertEquals(0.2, command.getLeftSignal(), 1e-9);
        assertEquals(0.6, command.getRightSignal(), 1e-9);
    }

    @Test
    void drivesUntilTheRunIsOver() throws Exception {
        List<Command> commands = new CopyOnWriteArrayList<>();
        try (var server = new TestServer()) {
            var environment = new HashMap<>(System.getenv());
            environment.put("BAUDBOT_CONNECT", server.address());
            environment.put("BAUDBOT_RECONNECT_S", "0");
            long tick = Link.drive("FollowTest.java", environment, body -> {
                var follow = new Follow(body);
                return turn -> {
                    var answer = follow.answer(turn);
                    commands.add(answer.getCommand());
                    return answer;
                };
            });
            assertEquals(1000, tick);
        }
        long forwards = commands.stream().filter(c -> c.getLeftSignal() + c.getRightSignal() > 0.0).count();
        assertTrue(forwards > 100, forwards + " of " + commands.size() + " commands drive forwards");
    }
}
