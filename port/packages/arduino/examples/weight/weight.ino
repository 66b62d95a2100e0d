/* Weight on a load cell (5 kg, HX711, 10 Hz): quiet while it rests, at once when something is put on. */
#include <kalmanq.h>

const float full_scale_g = 5000, full_scale_V = 4.3e-3f;           /* a cell of 1 mV/V at 4.3 V */
const float cell_g = 50e-9f / full_scale_V * full_scale_g;         /* HX711: 50 nV RMS at a gain of 128, 10 Hz: 0.06 g */
const float creep_g = 0.005f;                                      /* how far the weight drifts from row to row */

KQ_PROCESS_F32(creep, 1, 0);
KQ_SENSOR_F32(cell, 1, 1);
KQ_FILTER_F32(weight, 1);
const float R = cell_g * cell_g;

float noise() { float sum = -6; for (int i = 0; i < 12; i++) sum += random(1001) / 1000.0f; return sum; } /* of sigma 1 */

/* Yours: return scale.get_units(); of HX711, in grams */
float read_weight_g()
{
    static int row;
    return (++row > 100 ? 250 : 0) + cell_g * noise(); /* 250 g after 10 s */
}

void setup()
{
    static const float one = 1, Q = creep_g * creep_g, x0 = 0, P0 = 1e6f;
    Serial.begin(115200);
    if (kq_process_init_f32(&creep, &one, NULL, &Q) || kq_sensor_init_lean_f32(&cell, &one, &R) || kq_filter_init_f32(&weight, &x0, &P0))
        Serial.println("refused");
}

void loop()
{
    float z = read_weight_g();
    bool is_new = fabs(z - kq_mean_f32(&weight, 0)) > 5 * (cell_g + kq_sigma_f32(&weight, 0)); /* more than noise: begin there */
    if (is_new ? kq_filter_init_f32(&weight, &z, &R) : kq_step_f32(&weight, &creep, NULL, &cell, &z)) Serial.println("refused");
    Serial.print(kq_mean_f32(&weight, 0)); Serial.print(" g +- "); Serial.println(kq_sigma_f32(&weight, 0));
    delay(100);
}
