/* The settings of a serial line on Linux and macOS: 8 bits, no parity, one stop bit, no flow control, any speed. */
#include "serial.h"

#if defined(__linux__)
#include <asm/ioctls.h>
#include <asm/termbits.h>
#include <sys/ioctl.h>

/* By the kernel's own calls: those of the C library know some speeds only, and their constants differ between its versions. */
bool serial_set(int file, int baud)
{
    struct termios2 t;
    if (ioctl(file, TCGETS2, &t) != 0) {
        return false;
    }
    t.c_iflag = t.c_oflag = t.c_lflag = 0;
    t.c_cflag = CS8 | CLOCAL | CREAD | BOTHER | (BOTHER << IBSHIFT);
    t.c_ispeed = t.c_ospeed = (speed_t)baud;
    t.c_cc[VMIN] = t.c_cc[VTIME] = 0;
    return ioctl(file, TCSETS2, &t) == 0 && ioctl(file, TCFLSH, TCIOFLUSH) == 0;
}
#elif !defined(_WIN32)
#include <termios.h>

bool serial_set(int file, int baud)
{
    struct termios t;
    if (tcgetattr(file, &t) != 0) {
        return false;
    }
    cfmakeraw(&t);
    t.c_cflag = (t.c_cflag & ~(tcflag_t)(CSTOPB | CRTSCTS)) | CLOCAL | CREAD;
    t.c_cc[VMIN] = t.c_cc[VTIME] = 0;
    return cfsetspeed(&t, (speed_t)baud) == 0 && tcsetattr(file, TCSANOW, &t) == 0 && tcflush(file, TCIOFLUSH) == 0;
}
#endif
