// Looks at clocks, sleeps and does other things as a seed says, in several tasks and handlers. Prints all that it has seen.
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static int port;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

static unsigned next(unsigned *seed) {
    *seed = *seed * 1103515245 + 12345;
    return *seed >> 16 & 0x7fff;
}

int time_t_of(struct timeval *day);

static void look(const char *who, unsigned *seed) {
    struct timespec time = {-1, -1};
    struct timeval day = {-1, -1};
    struct timezone zone = {-1, -1};
    int answer, kind = next(seed) % 8, clock = (int)(next(seed) % 14) - 1;
    switch (kind) {
    case 0: answer = gettimeofday(&day, NULL); break;
    case 1: answer = gettimeofday(&day, &zone); break;
    case 2: day.tv_sec = time_t_of(&day); answer = 0; break;
    case 3: answer = syscall(SYS_clock_gettime, clock, &time); break;
    default: answer = clock_gettime(clock, &time);
    }
    printf("%s %d/%d: %d %ld.%ld %ld.%ld %d\n", who, kind, clock, answer, time.tv_sec, time.tv_nsec, day.tv_sec, day.tv_usec,
           zone.tz_minuteswest);
}

int time_t_of(struct timeval *day) {
    time_t told;
    return time(&told) == told ? told : 0;
}

static unsigned handled = 7;
static void handler(int signal) {
    for (unsigned i = next(&handled) % 40; i > 0; i--) look("handler", &handled);
}

static void act(const char *who, unsigned *seed, int depth) {
    char byte;
    int status;
    switch (next(seed) % (depth ? 11 : 13)) {
    case 0: usleep(next(seed) % 3000); break;
    case 1: sched_yield(); break;
    case 2: usleep(0); break;
    case 3: read(port, &byte, 1); break;
    case 4: write(port, "x", 1); break;
    case 5: pthread_mutex_lock(&mutex); usleep(next(seed) % 500); pthread_mutex_unlock(&mutex); break;
    case 6: printf("%s counter %llu\n", who, (unsigned long long)__builtin_ia32_rdtsc()); break;
    case 7: ualarm(1 + next(seed) % 2000, 0); break;
    case 8: kill(getpid(), SIGUSR1); break;
    case 9: close(open("/dev/null", O_RDONLY)); break;
    case 10: for (unsigned i = next(seed) % 250; i > 0; i--) look(who, seed); break;
    case 11:
        fflush(stdout);
        if (fork() == 0) {
            alarm(0);
            for (int i = 0; i < 12; i++) usleep(next(seed) % 2 * 300), look("child", seed);
            fflush(stdout);
            _exit(0);
        }
        for (int i = 0; i < 5; i++) look(who, seed);
        while (wait(&status) < 0 && errno == EINTR) {}
        break;
    default: fflush(stdout); system("date +%s.%N; sleep 0.001; date +%N"); break;
    }
    for (unsigned i = next(seed) % 20; i > 0; i--) look(who, seed);
}

static void *worker(void *seed) {
    unsigned own = (unsigned)(long)seed;
    for (int i = 0; i < 25; i++) act("worker", &own, 1);
    return NULL;
}

int main(int count, char **words) {
    unsigned seed = atoi(words[2]);
    pthread_t threads[2];
    setvbuf(stdout, NULL, _IOFBF, 1 << 20);
    port = open(words[1], O_RDWR | O_NOCTTY | O_NONBLOCK);
    struct sigaction action = {.sa_handler = handler, .sa_flags = seed & 1 ? SA_RESTART : 0};
    sigaction(SIGALRM, &action, NULL);
    sigaction(SIGUSR1, &action, NULL);
    for (long i = 0; i < 2; i++) pthread_create(&threads[i], NULL, worker, (void *)(i + 100L * seed));
    for (int i = 0; i < 40; i++) act("main", &seed, 0);
    for (int i = 0; i < 2; i++) pthread_join(threads[i], NULL);
    return 0;
}
