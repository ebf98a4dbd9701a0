// A port as the system sets it: lines, echo, mapped ends of lines. Prints what reads give.
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/uio.h>
#include <termios.h>
#include <unistd.h>

static int port;

static void look(int room) {
    char bytes[64];
    int count = read(port, bytes, room);
    printf("%d:", count);
    for (int i = 0; i < count; i++) printf(" %02x", bytes[i] & 255);
    printf("\n");
}

int main(int count, char **words) {
    int there;
    port = open(words[1], O_RDWR | O_NOCTTY);
    struct termios settings;
    tcgetattr(port, &settings);
    settings.c_lflag &= ~ECHO;
    tcsetattr(port, TCSANOW, &settings);
    struct iovec pieces[2] = {{"ab", 2}, {"c\r", 2}};
    writev(port, pieces, 2);
    look(2);
    look(9);
    struct pollfd question = {port, POLLIN, 0};
    write(port, "xy", 2);
    printf("poll %d\n", poll(&question, 1, 100));
    write(port, "\x7fz\x04", 3);
    look(9);
    settings.c_lflag |= ECHO;
    tcsetattr(port, TCSANOW, &settings);
    write(port, "\x04", 1);
    look(9);
    settings.c_lflag &= ~(ICANON | ECHO);
    settings.c_iflag = ISTRIP | INLCR;
    tcsetattr(port, TCSANOW, &settings);
    write(port, "\xc1\r", 2);
    usleep(100000);
    ioctl(port, FIONREAD, &there);
    printf("there %d\n", there);
    look(9);
    return 0;
}
