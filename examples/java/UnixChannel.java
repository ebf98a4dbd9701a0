import io.netty.buffer.ByteBuf;
import io.netty.channel.ChannelConfig;
import io.netty.channel.ChannelFuture;
import io.netty.channel.ChannelOption;
import io.netty.channel.DefaultChannelConfig;
import io.netty.channel.EventLoopGroup;
import io.netty.channel.FileRegion;
import io.netty.channel.nio.AbstractNioByteChannel;
import io.netty.channel.nio.NioEventLoopGroup;
import io.netty.util.concurrent.DefaultThreadFactory;
import java.io.IOException;
import java.io.UncheckedIOException;
import java.net.SocketAddress;
import java.net.StandardProtocolFamily;
import java.nio.channels.SelectionKey;
import java.nio.channels.SocketChannel;

/** A Unix socket for Netty, made of Java's own: Netty's needs native code that Debian does not have. */
final class UnixChannel extends AbstractNioByteChannel {
    static final EventLoopGroup LOOP = new NioEventLoopGroup(1, new DefaultThreadFactory("unix", true));

    private final ChannelConfig config = new DefaultChannelConfig(this) {
        @Override
        public <T> boolean setOption(ChannelOption<T> option, T value) {
            return super.setOption(option, value) || option == ChannelOption.SO_KEEPALIVE; // gRPC asks for it: only TCP has it
        }
    };

    private SocketAddress remote;

    UnixChannel() {
        super(null, open());
    }

    private static SocketChannel open() {
        try {
            return SocketChannel.open(StandardProtocolFamily.UNIX);
        } catch (IOException error) {
            throw new UncheckedIOException(error);
        }
    }

    @Override
    protected SocketChannel javaChannel() {
        return (SocketChannel) super.javaChannel();
    }

    @Override
    public ChannelConfig config() {
        return config;
    }

    @Override
    public boolean isActive() {
        return javaChannel().isOpen() && javaChannel().isConnected();
    }

    @Override
    protected boolean doConnect(SocketAddress remote, SocketAddress local) throws IOException {
        this.remote = remote;
        boolean isConnected = javaChannel().connect(remote);
        if (!isConnected) {
            selectionKey().interestOps(SelectionKey.OP_CONNECT);
        }
        return isConnected;
    }

    @Override
    protected void doFinishConnect() throws IOException {
        javaChannel().finishConnect();
    }

    @Override
    protected int doReadBytes(ByteBuf buffer) throws IOException {
        unsafe().recvBufAllocHandle().attemptedBytesRead(buffer.writableBytes());
        return buffer.writeBytes(javaChannel(), buffer.writableBytes());
    }

    @Override
    protected int doWriteBytes(ByteBuf buffer) throws IOException {
        return buffer.readBytes(javaChannel(), buffer.readableBytes());
    }

    @Override
    protected void doClose() throws IOException {
        javaChannel().close();
    }

    @Override
    protected void doDisconnect() throws IOException {
        doClose();
    }

    @Override
    protected SocketAddress localAddress0() {
        return null; // a client's has no name
    }

    @Override
    protected SocketAddress remoteAddress0() {
        return remote;
    }

    @Override
    protected void doBind(SocketAddress local) {
        throw new UnsupportedOperationException("a client has no address to bind");
    }

    @Override
    protected long doWriteFileRegion(FileRegion region) {
        throw new UnsupportedOperationException("gRPC sends no files");
    }

    @Override
    protected ChannelFuture shutdownInput() {
        throw new UnsupportedOperationException("gRPC closes both directions at once");
    }
}
