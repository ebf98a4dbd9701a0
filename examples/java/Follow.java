import baudbot.v1.*;
import java.util.function.ToDoubleBiFunction;

/** A brain that follows the wall on its right: that of one robot, for as long as a connection lasts. */
final class Follow implements Link.Brain {
    static final double SPEED = 0.4, GAIN = 1.0;
    /** Nearness of the wall that it keeps: 0 is out of range, 1 is very near. */
    static final double WANTED = 0.3;

    private static final long PATIENCE_NS = 100_000_000;
    private final RobotDescription body;
    private long repeatNs = 0;

    Follow(RobotDescription body) {
        this.body = body;
    }

    /** Drives where BAUDBOT_CONNECT, BAUDBOT_WORLD and BAUDBOT_ROBOT say, which {@code baudbot run} sets. */
    public static void main(String[] arguments) throws InterruptedException {
        try {
            long tick = Link.drive("Follow.java", System.getenv(), Follow::new);
            System.out.println("the run is over at tick " + tick);
        } catch (Link.Failure failure) {
            System.err.println("follow: " + failure.getMessage());
            System.exit(1);
        }
    }

    /** What the brain does in a step. {@code value} gives a sensor's last reading, or the number if none has arrived yet. */
    static Command step(ToDoubleBiFunction<String, Double> value) {
        double ahead = Math.max(value.applyAsDouble("ir_front", 1.0), value.applyAsDouble("ir_front_left", 1.0));
        if (ahead > WANTED) {
            return drive(-0.5 * SPEED, 0.5 * SPEED); // a corner: to the left, on the spot
        }
        double right = Math.max(value.applyAsDouble("ir_right", 0.0), value.applyAsDouble("ir_front_right", 0.0));
        double turning = GAIN * SPEED * (right - WANTED); // too near: to the left
        return drive(SPEED - turning, SPEED + turning);
    }

    private static Command drive(double left, double right) {
        return Command.newBuilder().setLeftSignal(left).setRightSignal(right).build();
    }

    /** One command for each message, and another after 0.1 s without any: the cable may have lost the last one. */
    @Override
    public RobotStep.Builder answer(RobotTurn turn) {
        var answer = RobotStep.newBuilder();
        boolean isNews = turn.getHasMessage() || turn.getReadingsList().stream().anyMatch(Reading::getReadable);
        boolean wentBack = turn.getAtNs() + PATIENCE_NS < repeatNs; // the world has been reset
        if (isNews || wentBack || turn.getAtNs() >= repeatNs) {
            answer.setCommand(step((sensor, unread) -> Link.value(body, turn, sensor, unread)));
            repeatNs = turn.getAtNs() + PATIENCE_NS;
        }
        return answer.setUntilMessage(UntilMessage.newBuilder().setAtLatestNs(repeatNs));
    }
}
