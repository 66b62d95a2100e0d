# make USER_C_MODULES=PATH/kalmanq/port
KALMANQ_MODULE := $(USERMOD_DIR)
SRC_USERMOD += $(addprefix $(KALMANQ_MODULE)/, kalmanq_module.c filter_f32.c status.c)
CFLAGS_USERMOD += -I$(KALMANQ_MODULE)/../../include -fno-math-errno -ffp-contract=off
