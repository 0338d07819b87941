// uvcsim: a USB webcam (UVC 1.0, bulk) in user space, plugged into the kernel through usbip's vhci_hcd over a
// socketpair, so that the kernel's real `uvcvideo` driver makes the /dev/video node.
//   uvcsim [FPS]      SIGUSR1 = pull the plug, SIGUSR2 = plug in again
// It shows what lies in the file that UVCSIM_PICTURE names, looked at before each frame (to be replaced by renaming): a
// gray PGM of the size that is streamed, or anything else, whose bytes are sent as they are where the format is MJPG.
// Without one, its frames are even, brighter from one to the next.
// UVCSIM_FORCES="FORMAT FRAME", two numbers from 1, 0 for any: it answers with these, whatever it is asked for.
// Needs the modules vhci_hcd and uvcvideo, and root.
#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iterator>
#include <string>
#include <vector>

#include "tests/v4l2_vm/uvcsim_pictures.h"
static double now() {
  timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec + t.tv_nsec * 1e-9;
}

// ---- descriptors
static void le(bytes& b, uint32_t v, int n) {
  for (int i = 0; i < n; ++i) b.push_back(uint8_t(v >> 8 * i));
}
static void cat(bytes& b, const bytes& o) {
  b.insert(b.end(), o.begin(), o.end());
}
static const uint32_t kIntervals[] = {166667, 333333, 666666};  // 60, 30, 15 fps, in 100 ns
static const int kPayload = 16384, kHeader = 2;
static bytes device_desc() {
  return {18, 1, 0x00, 0x02, 0xEF, 2, 1, 64, 0x34, 0x12, 0x78, 0x56, 0x00, 0x01, 1, 2, 0, 1};
}
static bytes config_desc() {
  bytes units;
  cat(units, {18, 0x24, 2, 1, 0x01, 0x02, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0x0A, 0, 0});  // camera: AE mode, exposure time
  cat(units, {11, 0x24, 5, 2, 1, 0, 0, 2, 0x01, 0x02, 0});                          // processing: brightness, gain
  cat(units, {9, 0x24, 3, 3, 0x01, 0x01, 0, 2, 0});                                 // output terminal
  bytes vc{13, 0x24, 1, 0x00, 0x01};
  le(vc, 13 + units.size(), 2);
  le(vc, 6000000, 4);
  cat(vc, {1, 1});
  cat(vc, units);
  bytes fmts;
  int fi = 0;
  for (auto& f : kFormats) {
    if (is_jpeg(f)) {
      cat(fmts, {11, 0x24, 6, uint8_t(++fi), uint8_t(std::size(kSizes)), 0, 1, 0, 0, 0, 0});
    } else {
      cat(fmts, {27, 0x24, 4, uint8_t(++fi), uint8_t(std::size(kSizes))});
      for (int i = 0; i < 4; ++i) fmts.push_back(f.fourcc[i]);
      cat(fmts, {0, 0, 0x10, 0, 0x80, 0, 0, 0xAA, 0, 0x38, 0x9B, 0x71, uint8_t(8 * f.bpp), 1, 0, 0, 0, 0});
    }
    int k = 0;
    for (auto& s : kSizes) {
      uint32_t sz = s.w * s.h * f.bpp;
      cat(fmts, {uint8_t(26 + 4 * std::size(kIntervals)), 0x24, uint8_t(is_jpeg(f) ? 7 : 5), uint8_t(++k), 0});
      le(fmts, s.w, 2);
      le(fmts, s.h, 2);
      le(fmts, sz * 8 * 15, 4);
      le(fmts, sz * 8 * 60, 4);
      le(fmts, sz, 4);
      le(fmts, kIntervals[1], 4);
      le(fmts, std::size(kIntervals), 1);
      for (auto i : kIntervals) le(fmts, i, 4);
    }
    cat(fmts, {6, 0x24, 0x0D, 1, 1, 4});
  }
  int nf = std::size(kFormats);
  bytes vs{uint8_t(13 + nf), 0x24, 1, uint8_t(nf)};
  le(vs, 13 + nf + fmts.size(), 2);
  cat(vs, {0x81, 0, 3, 0, 0, 0, 1});
  for (int i = 0; i < nf; ++i) vs.push_back(0);
  cat(vs, fmts);
  bytes body{8, 0x0B, 0, 2, 0x0E, 3, 0, 0};
  cat(body, {9, 4, 0, 0, 0, 0x0E, 1, 0, 0});
  cat(body, vc);
  cat(body, {9, 4, 1, 0, 1, 0x0E, 2, 0, 0});
  cat(body, vs);
  cat(body, {7, 5, 0x81, 2, 0x00, 0x02, 0});
  bytes c{9, 2};
  le(c, 9 + body.size(), 2);
  cat(c, {2, 1, 0, 0x80, 250});
  cat(c, body);
  return c;
}
static bytes string_desc(int i) {
  if (i == 0) return {4, 3, 9, 4};
  const char* s = i == 1 ? "uvcsim" : "Simulated webcam";
  bytes b{0, 3};
  for (; *s; ++s) {
    b.push_back(*s);
    b.push_back(0);
  }
  b[0] = b.size();
  return b;
}

// ---- device state
struct Control {
  int unit, cs, size;
  uint32_t min, max, res, def, cur;
};
static Control controls[] = {{1, 2, 1, 0, 0, 9, 8, 8},
                             {1, 4, 4, 1, 10000, 1, 156, 156},
                             {2, 2, 2, 0, 255, 1, 128, 128},
                             {2, 4, 2, 0, 100, 1, 0, 0}};
struct Stream {
  uint8_t fmt = 1, frame = 1;
  uint32_t interval = 333333;
} probe_, commit_;
static bool streaming = false;
static uint8_t fid = 0;
static uint32_t frame_no = 0;
static size_t sent = 0;
static double due = 0;
static bytes image;
static double fps_override = 0;
static uint32_t frame_size(const Stream& s) {
  auto& z = kSizes[s.frame - 1];
  return z.w * z.h * kFormats[s.fmt - 1].bpp;
}
static bytes stream_ctrl(const Stream& s) {
  bytes b;
  le(b, 1, 2);
  le(b, s.fmt, 1);
  le(b, s.frame, 1);
  le(b, s.interval, 4);
  le(b, 0, 8);
  le(b, 0, 2);
  le(b, frame_size(s), 4);
  le(b, kPayload, 4);
  return b;
}
static unsigned forced_format = 0, forced_frame = 0;
static Stream parse_ctrl(const bytes& d) {
  Stream s;
  s.fmt = forced_format ? forced_format : d[2];
  s.frame = forced_frame ? forced_frame : d[3];
  if (s.fmt < 1 || s.fmt > std::size(kFormats)) s.fmt = 1;
  if (s.frame < 1 || s.frame > std::size(kSizes)) s.frame = 1;
  uint32_t v = d[4] | d[5] << 8 | d[6] << 16 | uint32_t(d[7]) << 24;
  s.interval = kIntervals[0];
  for (auto i : kIntervals)
    if (labs(long(i) - long(v)) < labs(long(s.interval) - long(v))) s.interval = i;
  return s;
}
static void start_frame() {
  image = picture(kFormats[commit_.fmt - 1], kSizes[commit_.frame - 1], uint8_t(frame_no));
  ++frame_no;
  sent = 0;
  fid ^= 1;
}
// One control transfer: true = fine (answer in out), false = stall.
static bool control(const uint8_t* s, const bytes& data, bytes& out) {
  int type = s[0], req = s[1], val = s[2] | s[3] << 8, idx = s[4] | s[5] << 8;
  if ((type & 0x60) == 0) switch (req) {
      case 6:
        switch (val >> 8) {
          case 1:
            out = device_desc();
            return true;
          case 2:
            out = config_desc();
            return true;
          case 3:
            out = string_desc(val & 255);
            return true;
          default:
            return false;
        }
      case 0:
        out = {0, 0};
        return true;
      case 1:
        streaming = false;
        return true;  // CLEAR_FEATURE(HALT): how uvcvideo stops a bulk stream
      case 3:
      case 9:
      case 11:
        return true;
      default:
        return false;
    }
  int intf = idx & 255, unit = idx >> 8, cs = val >> 8;
  if (intf == 1 && (cs == 1 || cs == 2)) {
    Stream& st = cs == 1 ? probe_ : commit_;
    switch (req) {
      case 0x01:
        if (data.size() < 8) return false;
        st = parse_ctrl(data);
        if (cs == 2) {
          streaming = true;
          due = now();
          sent = 0;
          image.clear();
        }
        return true;
      case 0x81:
      case 0x82:
      case 0x83:
      case 0x87:
        out = stream_ctrl(st);
        return true;
      case 0x85:
        out = {26, 0};
        return true;
      case 0x86:
        out = {3};
        return true;
    }
    return false;
  }
  if (intf == 0 && unit == 0) {
    out = {0};
    return true;
  }
  for (auto& c : controls)
    if (c.unit == unit && c.cs == cs) {
      uint32_t v = c.cur;
      switch (req) {
        case 0x01:
          c.cur = 0;
          for (size_t i = 0; i < data.size() && i < 4; ++i) c.cur |= uint32_t(data[i]) << 8 * i;
          fprintf(stderr, "uvcsim: control %d/%d = %u\n", unit, cs, c.cur);
          return true;
        case 0x86:
          out = {3};
          return true;
        case 0x85:
          le(out, c.size, 2);
          return true;
        case 0x82:
          v = c.min;
          break;
        case 0x83:
          v = c.max;
          break;
        case 0x84:
          v = c.res;
          break;
        case 0x87:
          v = c.def;
          break;
        case 0x81:
          break;
        default:
          return false;
      }
      le(out, v, c.size);
      return true;
    }
  return false;
}

// ---- usbip
struct Urb {
  uint32_t seq;
  int len;
};
static std::deque<Urb> pending;
static int sock = -1;
static volatile sig_atomic_t want = 1;
static bool rd(void* p, size_t n) {
  auto c = (char*)p;
  while (n) {
    ssize_t k = read(sock, c, n);
    if (k <= 0) return false;
    c += k;
    n -= k;
  }
  return true;
}
static bool wr(const void* p, size_t n) {
  auto c = (const char*)p;
  while (n) {
    ssize_t k = send(sock, c, n, MSG_NOSIGNAL);
    if (k <= 0) return false;
    c += k;
    n -= k;
  }
  return true;
}
static bool reply(uint32_t cmd, uint32_t seq, int status, int actual, const bytes* data) {
  uint32_t h[12] = {htonl(cmd), htonl(seq), 0, 0, 0, htonl(status), htonl(actual)};
  bytes m(48);
  memcpy(m.data(), h, 48);
  if (data) m.insert(m.end(), data->begin(), data->begin() + actual);
  return wr(m.data(), m.size());
}
static void pump() {  // answer waiting bulk URBs with what the camera has by now
  double t = now();
  while (streaming && !pending.empty()) {
    if (sent >= image.size()) {
      if (t < due) return;
      double period = fps_override > 0 ? 1 / fps_override : commit_.interval * 1e-7;
      start_frame();
      due += period;
      if (due < t - 1) due = t;
    }
    Urb u = pending.front();
    pending.pop_front();
    size_t n = std::min<size_t>({image.size() - sent, size_t(kPayload - kHeader), size_t(u.len - kHeader)});
    bytes p{kHeader, uint8_t(0x80 | fid)};
    p.insert(p.end(), image.begin() + sent, image.begin() + sent + n);
    sent += n;
    if (sent >= image.size()) p[1] |= 2;
    if (!reply(3, u.seq, 0, p.size(), &p)) return;
  }
}
static bool one_message() {
  uint32_t h[12];
  if (!rd(h, 48)) return false;
  uint32_t cmd = ntohl(h[0]), seq = ntohl(h[1]), dir = ntohl(h[3]), ep = ntohl(h[4]);
  if (cmd == 2) {
    uint32_t victim = ntohl(h[5]);
    int st = 0;
    for (auto i = pending.begin(); i != pending.end(); ++i)
      if (i->seq == victim) {
        pending.erase(i);
        st = -ECONNRESET;
        break;
      }
    return reply(4, seq, st, 0, nullptr);
  }
  int len = ntohl(h[6]);
  bytes data;
  if (dir == 0 && len > 0) {
    data.resize(len);
    if (!rd(data.data(), len)) return false;
  }
  if (ep == 0) {
    bytes out;
    const uint8_t* s = (uint8_t*)&h[10];
    bool ok = control(s, data, out);
    if (getenv("UVCSIM_DEBUG"))
      fprintf(stderr, "uvcsim: ctrl %02x %02x %02x%02x %02x%02x len %d -> %s %zu\n", s[0], s[1], s[3], s[2], s[5], s[4],
              len, ok ? "ok" : "stall", out.size());
    if (dir == 1) {
      if ((int)out.size() > len) out.resize(len);
      return reply(3, seq, ok ? 0 : -EPIPE, ok ? out.size() : 0, ok ? &out : nullptr);
    }
    return reply(3, seq, ok ? 0 : -EPIPE, ok ? len : 0, nullptr);
  }
  pending.push_back({seq, len});
  return true;
}
static void attach() {
  int sv[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, sv)) {
    perror("socketpair");
    exit(1);
  }
  int f = open("/sys/devices/platform/vhci_hcd.0/attach", O_WRONLY);
  if (f < 0) {
    perror("vhci_hcd attach");
    exit(1);
  }
  char b[64];
  int n = snprintf(b, sizeof b, "0 %d 65538 3", sv[1]);  // port 0, devid, high speed
  if (write(f, b, n) != n) {
    perror("attach");
    exit(1);
  }
  close(f);
  close(sv[1]);
  sock = sv[0];
  pending.clear();
  streaming = false;
  fprintf(stderr, "uvcsim: plugged in\n");
}
int main(int argc, char** argv) {
  if (argc > 1) fps_override = atof(argv[1]);
  if (const char* forced = getenv("UVCSIM_FORCES")) sscanf(forced, "%u %u", &forced_format, &forced_frame);
  struct sigaction a {};
  a.sa_handler = [](int s) { want = s == SIGUSR2; };
  sigaction(SIGUSR1, &a, nullptr);
  sigaction(SIGUSR2, &a, nullptr);
  for (;;) {
    if (want && sock < 0) attach();
    if (!want && sock >= 0) {
      close(sock);
      sock = -1;
      fprintf(stderr, "uvcsim: unplugged\n");
    }
    pollfd p{sock, POLLIN, 0};
    int ms = 20;
    if (streaming) {
      ms = int((due - now()) * 1e3);
      ms = ms < 0 ? 0 : ms > 20 ? 20 : ms;
      if (pending.empty() && ms < 1) ms = 5;
    }
    poll(&p, sock >= 0 ? 1 : 0, ms);
    if (sock >= 0 && p.revents && !one_message()) {
      fprintf(stderr, "uvcsim: host closed\n");
      close(sock);
      sock = -1;
      want = 0;
    }
    if (sock >= 0) pump();
  }
}
