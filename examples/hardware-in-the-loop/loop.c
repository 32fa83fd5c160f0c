/* A model's C against the clock, in the loop with another program: after each step it sends the outputs by UDP, and before
 * each step it takes the newest inputs. Packets are those of `mimbre live --udp` (docs/exchange.md), so that the same
 * controllers take part. At the end it prints how the steps kept their time.
 *
 * For Linux. The model is code of `mimbre generate MODEL --name model -o code`; README.md has the commands. */
#define _GNU_SOURCE
#include <errno.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "mimbre/exchange_layout.h"
#include "model.h"

static const char *const input_names[] = {MODEL_INPUT_NAMES ""};
static const char *const input_units[] = {MODEL_INPUT_UNITS ""};
static const char *const output_names[] = {MODEL_OUTPUT_NAMES ""};
static const char *const output_units[] = {MODEL_OUTPUT_UNITS ""};

static model the_model;

/* --- The other program --- */

enum { longest_packet = 65000, most_packets = 32 /* that are looked at before a step */ };

static struct {
  int socket;
  struct sockaddr_storage peer;
  socklen_t peer_size; /* 0: nobody takes part */
  uint64_t layout, since; /* of the names; the step after which the peer came */
  uint64_t newest;        /* of inputs */
  size_t names_size;
  char names[longest_packet];
  union {
    mimbre_exchange_head head;
    unsigned char bytes[longest_packet];
  } packet;
} link_;

static void add_names(const char *word, int count, const char *const *names, const char *const *units) {
  int k;
  size_t at = link_.names_size;
  at += (size_t)snprintf(link_.names + at, sizeof link_.names - at, "%s %d\n", word, count);
  for (k = 0; k < count && at < sizeof link_.names; ++k)
    at += (size_t)snprintf(link_.names + at, sizeof link_.names - at, "%s\t%s\n", names[k], units[k]);
  if (at >= sizeof link_.names - sizeof(mimbre_exchange_head)) {
    fprintf(stderr, "the names of the variables do not fit into a packet\n");
    exit(1);
  }
  link_.names_size = at;
}

static void open_link(int port) {
  struct sockaddr_in own;
  size_t k;
  memset(&own, 0, sizeof own);
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_ANY);
  own.sin_port = htons((uint16_t)port);
  if (port < 0 || port > 65535 ||
      (MODEL_OUTPUTS > MODEL_INPUTS ? MODEL_OUTPUTS : MODEL_INPUTS)*sizeof(double) > longest_packet - sizeof(mimbre_exchange_head)) {
    fprintf(stderr, "the port is none, or the variables do not fit into a packet\n");
    exit(1);
  }
  link_.socket = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0);
  if (link_.socket < 0 || bind(link_.socket, (struct sockaddr *)&own, sizeof own) != 0) {
    fprintf(stderr, "cannot take packets at port %d: %s\n", port, strerror(errno));
    exit(1);
  }
  add_names("outputs", MODEL_OUTPUTS, output_names, output_units);
  add_names("inputs", MODEL_INPUTS, input_names, input_units);
  link_.layout = 14695981039346656037u; /* FNV-1a */
  for (k = 0; k < link_.names_size; ++k)
    link_.layout = (link_.layout ^ (unsigned char)link_.names[k])*1099511628211u;
}

/* What cannot be sent now is lost, as any packet may be. */
static void send_packet(uint16_t kind, uint16_t count, uint64_t sequence, const void *body, size_t size) {
  mimbre_exchange_head *const head = &link_.packet.head;
  head->magic = MIMBRE_EXCHANGE_MAGIC;
  head->kind = kind;
  head->count = count;
  head->layout = link_.layout;
  head->sequence = sequence;
  head->time = model_time(&the_model);
  memcpy(head + 1, body, size);
  (void)sendto(link_.socket, link_.packet.bytes, sizeof *head + size, 0, (struct sockaddr *)&link_.peer, link_.peer_size);
}

/* The packets that have come, so many before a step. `step`: how many steps were made. */
static void take_packets(uint64_t step) {
  int taken, greeted = 0;
  for (taken = 0; taken < most_packets; ++taken) {
    struct sockaddr_storage from;
    socklen_t from_size = sizeof from;
    const ssize_t size =
        recvfrom(link_.socket, link_.packet.bytes, sizeof link_.packet.bytes, 0, (struct sockaddr *)&from, &from_size);
    const mimbre_exchange_head head = link_.packet.head;
    int known;
    if (size < 0) return;
    if ((size_t)size < sizeof head || head.magic != MIMBRE_EXCHANGE_MAGIC) continue;
    if (head.kind == MIMBRE_EXCHANGE_HELLO) {
      if (greeted++) continue;
      link_.newest = 0;
      link_.peer = from;
      link_.peer_size = from_size;
      link_.since = step;
      send_packet(MIMBRE_EXCHANGE_NAMES, (uint16_t)link_.names_size, 0, link_.names, link_.names_size);
      continue;
    }
    known = from_size == link_.peer_size && memcmp(&from, &link_.peer, from_size) == 0;
    if (!known || head.layout != link_.layout) continue;
    if (head.kind == MIMBRE_EXCHANGE_BYE) link_.peer_size = 0;
    if (head.kind == MIMBRE_EXCHANGE_INPUTS && head.count == MODEL_INPUTS &&
        (size_t)size == sizeof head + MODEL_INPUTS*sizeof(double) &&
        (head.sequence == 0 || head.sequence >= link_.newest)) {
      int k;
      link_.newest = head.sequence;
      for (k = 0; k < MODEL_INPUTS; ++k) {
        double value;
        memcpy(&value, link_.packet.bytes + sizeof head + (size_t)k*sizeof value, sizeof value);
        model_set_input(&the_model, k, value); /* what is no number is refused, and stays as it is */
      }
    }
  }
}

/* --- The clock --- */

static const long second = 1000000000;

static int64_t now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (int64_t)t.tv_sec*second + t.tv_nsec;
}

static void sleep_until(int64_t instant) {
  struct timespec t;
  t.tv_sec = (time_t)(instant/second);
  t.tv_nsec = (long)(instant%second);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) {}
}

/* The loop preempts other programs, on a processor of its own, and its memory stays. */
static void take_the_machine(int priority, int processor) {
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) fprintf(stderr, "the memory is not locked: %s\n", strerror(errno));
  if (processor >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)processor, &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0)
      fprintf(stderr, "not on processor %d alone: %s\n", processor, strerror(errno));
  }
  if (priority > 0) {
    struct sched_param as;
    memset(&as, 0, sizeof as);
    as.sched_priority = priority;
    if (sched_setscheduler(0, SCHED_FIFO, &as) != 0) fprintf(stderr, "no SCHED_FIFO: %s\n", strerror(errno));
  }
}

static int by_size(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return (x > y) - (x < y);
}

static void print_times(const char *what, float *times, long count) {
  qsort(times, (size_t)count, sizeof *times, by_size);
  printf("%-24s median %.4f   99.99 %% %.4f   worst %.4f ms\n", what, (double)times[count/2]*1e-6,
         (double)times[(long)((double)(count - 1)*0.9999)]*1e-6, (double)times[count - 1]*1e-6);
}

static volatile sig_atomic_t interrupted = 0;
static void interrupt(int signal) {
  (void)signal;
  interrupted = 1;
}

int main(int count, char **words) {
  static double outputs[MODEL_OUTPUTS + 1];
  const int64_t length = (int64_t)(MODEL_STEP*1e9 + 0.5);
  int port = 9000, priority = 0, processor = -1, option, status = MODEL_OK, k;
  long step, steps, late = 0, unconverged = 0;
  double duration = 10.0;
  float *work, *delay;
  int64_t start;
  while ((option = getopt(count, words, "u:p:c:d:")) != -1) {
    if (option == 'u') port = atoi(optarg);
    if (option == 'p') priority = atoi(optarg);
    if (option == 'c') processor = atoi(optarg);
    if (option == 'd') duration = atof(optarg);
    if (option == '?') {
      fprintf(stderr, "usage: %s [-u UDP port] [-p priority of SCHED_FIFO] [-c processor] [-d seconds]\n", words[0]);
      return 1;
    }
  }
  steps = duration >= 0.5*MODEL_STEP && duration < 1e8*MODEL_STEP ? (long)(duration/MODEL_STEP + 0.5) : 0;
  if (steps < 1) {
    fprintf(stderr, "the duration is shorter than a step, %g s, or longer than 1e8 of them\n", MODEL_STEP);
    return 1;
  }
  work = (float *)calloc((size_t)steps, sizeof *work);
  delay = (float *)calloc((size_t)steps, sizeof *delay);
  if (!work || !delay) {
    fprintf(stderr, "there is no memory for the times of %ld steps\n", steps);
    return 1;
  }
  signal(SIGINT, interrupt);
  signal(SIGTERM, interrupt);
  open_link(port);
  take_the_machine(priority, processor);
  model_init(&the_model);

  start = now() + second/100;
  for (step = 0; step < steps && !interrupted; ++step) {
    const int64_t due = start + step*length;
    int64_t begin, end;
    sleep_until(due);
    delay[step] = (float)(now() - due);
    take_packets((uint64_t)step);
    begin = now();
    status = model_step(&the_model);
    for (k = 0; k < MODEL_OUTPUTS; ++k) outputs[k] = model_get_output(&the_model, k);
    end = now();
    work[step] = (float)(end - begin);
    late += end > due + length;
    if (link_.peer_size > 0 && (status <= MODEL_UNCONVERGED || status == MODEL_ENDED))
      send_packet(MIMBRE_EXCHANGE_OUTPUTS, MODEL_OUTPUTS, (uint64_t)step + 1 - link_.since, outputs, MODEL_OUTPUTS*sizeof *outputs);
    unconverged += status == MODEL_UNCONVERGED;
    if (status > MODEL_UNCONVERGED) {
      ++step;
      break;
    }
  }
  printf("%ld steps of %g s, %ld not ready in time, %ld taken before they had converged\n", step, MODEL_STEP, late, unconverged);
  if (step > 0) {
    print_times("computation of a step", work, step);
    print_times("delay of a step's start", delay, step);
  }
  if (status > MODEL_UNCONVERGED && status != MODEL_ENDED) {
    fprintf(stderr, "a step could not be made: status %d\n", status);
    return 1;
  }
  return 0;
}
