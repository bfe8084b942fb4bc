/* Stands in for Arduino's: declares what the exported sketch calls. */
#include <stdint.h>
unsigned long millis(void);
