import baudbot.v1.AttachRequest;
import baudbot.v1.AttachResponse;
import baudbot.v1.RobotTurn;
import baudbot.v1.Step;
import baudbot.v1.Turn;
import io.grpc.Status;
import io.grpc.stub.ClientCallStreamObserver;
import io.grpc.stub.ClientResponseObserver;
import java.util.List;
import java.util.concurrent.CompletableFuture;

/** One stream with the server: it answers for the robots' brains, until it knows the run's last tick or why it ends without. */
final class Attachment implements ClientResponseObserver<AttachRequest, AttachResponse> {
    final CompletableFuture<Long> lastTick = new CompletableFuture<>();
    volatile boolean isAttached = false;
    private final Link.Maker maker;
    private List<Link.Brain> brains;
    private ClientCallStreamObserver<AttachRequest> requests;

    Attachment(Link.Maker maker) {
        this.maker = maker;
    }

    @Override
    public void beforeStart(ClientCallStreamObserver<AttachRequest> requests) {
        this.requests = requests;
    }

    @Override
    public void onNext(AttachResponse response) {
        switch (response.getResponseCase()) {
            case WELCOME -> {
                isAttached = true;
                brains = response.getWelcome().getRobotsList().stream().map(maker::make).toList();
            }
            case TURN -> requests.onNext(AttachRequest.newBuilder().setStep(answer(response.getTurn())).build());
            case ENDED -> lastTick.complete(response.getEnded().getTick());
            default -> { } // of a later version of the contract
        }
    }

    @Override
    public void onError(Throwable error) {
        lastTick.completeExceptionally(error);
    }

    @Override
    public void onCompleted() {
        onError(Status.UNAVAILABLE.withDescription("the server closed the connection before the run was over").asException());
    }

    private Step.Builder answer(Turn turn) {
        var step = Step.newBuilder().setTurn(turn.getTurn());
        for (RobotTurn robot : turn.getRobotsList()) {
            step.addRobots(brains.get(robot.getRobot()).answer(robot).setRobot(robot.getRobot()));
        }
        return step;
    }
}
