import baudbot.v1.BrainLinkServiceGrpc;
import baudbot.v1.RobotDescription;
import baudbot.v1.RobotStep;
import baudbot.v1.RobotTurn;
import io.grpc.ManagedChannel;
import io.grpc.Metadata;
import io.grpc.Status;
import io.grpc.netty.NettyChannelBuilder;
import io.grpc.stub.MetadataUtils;
import java.net.InetSocketAddress;
import java.net.URI;
import java.net.UnixDomainSocketAddress;
import java.util.Map;
import java.util.concurrent.ExecutionException;
import java.util.concurrent.TimeUnit;

/** The link between brains and their server. It knows nothing of any brain: keep this file, and replace Follow.java. */
final class Link {
    /** The brain of one robot, made anew for each connection. */
    interface Brain {
        RobotStep.Builder answer(RobotTurn turn);
    }

    /** Makes the brain of a robot. */
    interface Maker {
        Brain make(RobotDescription body);
    }

    /** Why a program ends before its run, in words for people. */
    static final class Failure extends Exception {
        Failure(String message) {
            super(message);
        }
    }

    private Link() {}

    /** A sensor's last reading, or {@code unread} if none has arrived yet. */
    static double value(RobotDescription body, RobotTurn turn, String sensor, double unread) {
        return turn.getReadingsList().stream()
                .filter(reading -> body.getSensors(reading.getSensor()).getSensor().equals(sensor))
                .mapToDouble(reading -> reading.getValues(0))
                .findFirst()
                .orElse(unread);
    }

    /** Drives until the run is over, and returns its last tick. After a lost connection it tries again, with new brains. */
    static long drive(String name, Map<String, String> environment, Maker maker) throws Failure, InterruptedException {
        var settings = new Settings(environment);
        double limitS = settings.reconnectS();
        boolean wasAttached = false, isLost = false;
        for (long lostAtNs = 0;; Thread.sleep(500)) {
            var attachment = new Attachment(maker);
            ManagedChannel channel = connect(settings);
            try {
                BrainLinkServiceGrpc.newStub(channel).attach(attachment).onNext(settings.hello(name));
                return attachment.lastTick.get();
            } catch (ExecutionException ended) {
                Throwable error = ended.getCause();
                if (error.getCause() instanceof RuntimeException bug && code(error) == Status.Code.CANCELLED) {
                    throw bug; // of a brain
                }
                wasAttached |= attachment.isAttached;
                isLost &= !attachment.isAttached;
                lostAtNs = isLost ? lostAtNs : System.nanoTime();
                if (!mayPass(error, wasAttached) || System.nanoTime() - lostAtNs >= 1e9 * limitS) {
                    throw new Failure(reason(error));
                }
                if (!isLost) {
                    String program = name.replace(".java", "").toLowerCase();
                    String limit = String.valueOf(limitS).replaceFirst("\\.0$", "");
                    System.err.printf("%s: connection lost (%s); trying again for %s s%n", program, reason(error), limit);
                }
                isLost = true;
            } finally {
                channel.shutdownNow();
            }
        }
    }

    private static ManagedChannel connect(Settings settings) throws Failure {
        var headers = new Metadata();
        if (!settings.token().isEmpty()) {
            headers.put(key("authorization"), "Bearer " + settings.token());
        }
        return channel(settings.address())
                .intercept(MetadataUtils.newAttachHeadersInterceptor(headers))
                .usePlaintext()
                .keepAliveTime(20, TimeUnit.SECONDS) // notices a server that has gone without a word
                .build();
    }

    /** A channel without gRPC's own resolver, which would ask for a proxy, and log each name that it does not find. */
    private static NettyChannelBuilder channel(String address) throws Failure {
        if (address.startsWith("unix:")) {
            return NettyChannelBuilder.forAddress(UnixDomainSocketAddress.of(address.substring("unix:".length())))
                    .overrideAuthority("localhost") // else it is the path, which servers refuse
                    .channelFactory(UnixChannel::new)
                    .eventLoopGroup(UnixChannel.LOOP);
        }
        try {
            var place = URI.create("http://" + address);
            return NettyChannelBuilder.forAddress(new InetSocketAddress(place.getHost(), place.getPort()));
        } catch (IllegalArgumentException error) {
            throw new Failure("BAUDBOT_CONNECT=" + address + ": must be HOST:PORT or unix:/PATH");
        }
    }

    private static boolean mayPass(Throwable error, boolean wasAttached) {
        return switch (code(error)) {
            case UNAVAILABLE -> true;
            case ALREADY_EXISTS -> wasAttached; // the server may not have noticed yet that the old connection is lost
            case ABORTED -> "restart".equals(Status.trailersFromThrowable(error).get(key("baudbot-reason")));
            default -> false;
        };
    }

    private static Status.Code code(Throwable error) {
        return Status.fromThrowable(error).getCode();
    }

    private static Metadata.Key<String> key(String name) {
        return Metadata.Key.of(name, Metadata.ASCII_STRING_MARSHALLER);
    }

    /** gRPC has many a reason in the cause. */
    private static String reason(Throwable error) {
        Status status = Status.fromThrowable(error);
        Throwable cause = status.getCause();
        boolean isMore = cause != null && cause.getMessage() != null;
        return isMore ? status.getDescription() + ": " + cause.getMessage() : status.getDescription();
    }
}
