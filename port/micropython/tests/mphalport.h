/* what py/mphal.h asks of a port: no pins */
#define mp_hal_pin_obj_t int
