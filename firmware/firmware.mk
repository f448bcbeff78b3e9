# The servo of one scene as an image for a microcontroller: build/<name>/firmware/<target>/. Included by the Makefile.
#
#   haptable.h, *.c + model.c + port/ -> objects -> ELF, bin, map -> size table and checks

TARGET ?= cortex-m7
TARGETS = cortex-m4 cortex-m7 cortex-m33 rv32
# What the part has. The linker stops where the image does not fit.
FLASH ?= 256K
RAM ?= 16K
STACK ?= 2K
TARGET_OPT ?= -O2

ARM = arm-none-eabi-
RISCV = riscv64-unknown-elf-
CROSS_cortex-m4  = $(ARM)
CROSS_cortex-m7  = $(ARM)
CROSS_cortex-m33 = $(ARM)
CROSS_rv32       = $(RISCV)
CORE_cortex-m4  = -mthumb -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard
CORE_cortex-m7  = -mthumb -mcpu=cortex-m7 -mfpu=fpv5-sp-d16 -mfloat-abi=hard
UART_cortex-m4  = haptable_uart_cmsdk.c
UART_cortex-m7  = haptable_uart_cmsdk.c
UART_cortex-m33 = haptable_uart_cmsdk.c
UART_rv32       = haptable_uart_16550.c
UART_AT_cortex-m4  = 0x40004000u
UART_AT_cortex-m7  = 0x40004000u
UART_AT_cortex-m33 = 0x40200000u
UART_AT_rv32       = 0x10000000u
UART_IRQ_cortex-m4  = 0u
UART_IRQ_cortex-m7  = 0u
UART_IRQ_cortex-m33 = 32u
UART_IRQ_rv32       = 0u
CORE_cortex-m33 = -mthumb -mcpu=cortex-m33 -mfpu=fpv5-sp-d16 -mfloat-abi=hard -DHAPTABLE_PORT_CLOCK_HZ=20000000u
CORE_rv32       = -march=rv32imafc -mabi=ilp32f -mcmodel=medany
PORT_cortex-m4  = haptable_cortex_m.c
PORT_cortex-m7  = haptable_cortex_m.c
PORT_cortex-m33 = haptable_cortex_m.c
PORT_rv32       = haptable_riscv.c haptable_riscv_start.S

TARGET_CC = $(CCACHE) $(CROSS_$(TARGET))gcc
# -ffp-contract=off: the host's bits. No C library: only the compiler's own <stdint.h> and <stddef.h>.
TARGET_CFLAGS = $(CORE_$(TARGET)) -std=c99 -ffreestanding $(TARGET_OPT) $(FP) -fno-math-errno \
    -fno-tree-loop-distribute-patterns -ffunction-sections -fdata-sections -fstack-usage -fcallgraph-info=su \
    $(C_WARN) -Ifirmware -Ifirmware/port -DHAPTABLE_PORT_UART=$(UART_AT_$(TARGET)) -DHAPTABLE_PORT_UART_IRQ=$(UART_IRQ_$(TARGET)) -MMD -MP
TARGET_LDFLAGS = $(CORE_$(TARGET)) -nostdlib -nostartfiles -Wl,--gc-sections -Wl,--fatal-warnings -Lfirmware/port \
    -Wl,--defsym=HAPTABLE_PORT_FLASH=$(FLASH) -Wl,--defsym=HAPTABLE_PORT_RAM=$(RAM) -Wl,--defsym=HAPTABLE_PORT_STACK=$(STACK) \
    -T firmware/port/$(TARGET).ld

# firmware: the servo of one scene for a microcontroller, with its size (make firmware SCENE=... TARGET=cortex-m7)
.PHONY: firmware
firmware: $(BUILD)/setup-cross.stamp
	@$(if $(CORE_$(TARGET)),,echo "TARGET=$(TARGET) is none of: $(TARGETS)" >&2; exit 1)
	@$(MAKE) --no-print-directory scene
	@name=$$($(BUILD)/bin/haptable-precompute --print-name '$(SCENE)') && \
	$(MAKE) --no-print-directory $(BUILD)/$$name/firmware/$(TARGET)/size.txt NAME=$$name && \
	cat $(BUILD)/$$name/firmware/$(TARGET)/size.txt

# firmware-diff: what the image's code, tables, state and stack grew by against main (make firmware-diff AGAINST=v0.1.0 TARGET=rv32)
AGAINST ?= main
.PHONY: firmware-diff
firmware-diff: firmware
	@sh scripts/firmware-against.sh $(AGAINST) $(BUILD) '$(MAKE)' 'SCENE=$(SCENE)' TARGET=$(TARGET) FLASH=$(FLASH) RAM=$(RAM) TARGET_OPT=$(TARGET_OPT)

# misra: where firmware/*.c deviates from MISRA C:2012, by cppcheck's addon; firmware/misra.txt says why
.PHONY: misra
misra: $(BUILD)/setup-lint.stamp
	@sh scripts/misra.sh --list

# loop: the servo on a microcontroller in a closed loop over LCM (make loop TARGET=cortex-m7; LINE=uart or LINE=/dev/ttyACM0)
LINE ?= pipes
BAUD ?= 1000000
LOOP_SECONDS ?= 10
.PHONY: loop
loop: firmware
	@name=$$($(BUILD)/bin/haptable-precompute --print-name '$(SCENE)') && \
	BUILD=$(BUILD) LINE=$(LINE) BAUD=$(BAUD) SECONDS_=$(LOOP_SECONDS) LOCKSTEP=$(LOCKSTEP) DEVICE_OPTIONS='$(DEVICE_OPTIONS)' \
	sh scripts/loop.sh $$name '$(SCENE)' $(TARGET)

# The images that the tests run: both scenes on every target, the cube in 64 KiB; without cross compilers, none
.PHONY: images
images: $(BUILD)/host/target/count.so
	@$(MAKE) --no-print-directory scene SCENE=meshes/cube.toml
	@$(MAKE) --no-print-directory scene SCENE=meshes/mouse.toml
	@$(MAKE) --no-print-directory scene SCENE=tests/firmware/display.toml
	@$(MAKE) --no-print-directory scene SCENE=meshes/free-cube.toml
	@$(MAKE) --no-print-directory scene SCENE=tests/firmware/modes.toml
	@$(MAKE) --no-print-directory scene SCENE=tests/firmware/grasp.toml
	@$(MAKE) --no-print-directory scene SCENE=tests/firmware/squeeze.toml
	@$(MAKE) --no-print-directory scene SCENE=tests/firmware/wobble.toml
	@$(MAKE) --no-print-directory scene SCENE=meshes/cube-two.toml
	@if sh scripts/setup.sh cross; then \
	for target in $(TARGETS); do \
	$(MAKE) --no-print-directory $(BUILD)/cube/firmware/$$target/size.txt $(BUILD)/cube/firmware/$$target/measure.elf $(BUILD)/cube/firmware/$$target/measure_pair.elf NAME=cube SCENE=meshes/cube.toml TARGET=$$target FLASH=64K && \
	$(MAKE) --no-print-directory $(BUILD)/mouse/firmware/$$target/size.txt NAME=mouse SCENE=meshes/mouse.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/display/firmware/$$target/deform.elf NAME=display SCENE=tests/firmware/display.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/free-cube/firmware/$$target/body.elf $(BUILD)/free-cube/firmware/$$target/loop_body.elf $(BUILD)/free-cube/firmware/$$target/uart_body.elf NAME=free-cube SCENE=meshes/free-cube.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/grasped/firmware/$$target/grasp.elf $(BUILD)/grasped/firmware/$$target/loop_body_pair.elf $(BUILD)/grasped/firmware/$$target/uart_body_pair.elf NAME=grasped SCENE=tests/firmware/grasp.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/ringing/firmware/$$target/modes.elf $(BUILD)/ringing/firmware/$$target/loop_modes.elf $(BUILD)/ringing/firmware/$$target/uart_modes.elf NAME=ringing SCENE=tests/firmware/modes.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/squeezed/firmware/$$target/modes_pair.elf NAME=squeezed SCENE=tests/firmware/squeeze.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/wobbling/firmware/$$target/grasp_modes.elf NAME=wobbling SCENE=tests/firmware/wobble.toml TARGET=$$target && \
	$(MAKE) --no-print-directory $(BUILD)/cube-two/firmware/$$target/loop_pair.elf $(BUILD)/cube-two/firmware/$$target/uart_pair.elf NAME=cube-two SCENE=meshes/cube-two.toml TARGET=$$target || exit 1; \
	done; else echo "no cross compilers: the tests on microcontrollers skip"; fi

# instructions: count the instructions of a tick on every emulated target
.PHONY: instructions
instructions: images $(BUILD)/bin/haptable-count
	$(BUILD)/bin/haptable-count $(BUILD)/cube $(BUILD)/mouse

$(BUILD)/host/target/count.so: host/target/plugin/count.c | $(BUILD)/setup.stamp
	$(say) C $<
	@mkdir -p $(@D)
	$(Q)$(CC) -std=c11 -O2 -Wall -Wextra $(WERROR) -shared -fPIC $< -o $@

ifdef NAME
IMAGE = $(BUILD)/$(NAME)/firmware/$(TARGET)
SERVO_TARGET = $(patsubst firmware/%.c,$(IMAGE)/%.o,$(wildcard firmware/*.c))
PORT_TARGET = $(addprefix $(IMAGE)/port/,$(addsuffix .o,$(basename $(PORT_$(TARGET)) haptable_semihosting haptable_memory haptable_ticks haptable_pair_ticks)))

$(IMAGE)/%.o: firmware/%.c $(IMAGE)/options
	$(say) $(TARGET) $<
	@mkdir -p $(@D)
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -I$(BUILD)/$(NAME) -c $< -o $@

# What reads no scene's model.h is compiled once for a target; every image has the same files in its folder.
FOR_EVERY_SCENE = $(BUILD)/firmware/$(TARGET)
OF_EVERY_SCENE = $(patsubst firmware/%,$(IMAGE)/%.o,$(basename $(wildcard firmware/*.c firmware/port/haptable_*.[cS])))
$(FOR_EVERY_SCENE)/%.o: firmware/%.c $(FOR_EVERY_SCENE)/options
	$(say) $(TARGET) $<
	@mkdir -p $(@D)
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $< -o $@

$(FOR_EVERY_SCENE)/%.o: firmware/%.S $(FOR_EVERY_SCENE)/options
	$(say) $(TARGET) $<
	@mkdir -p $(@D)
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $< -o $@

$(OF_EVERY_SCENE): $(IMAGE)/%.o: $(FOR_EVERY_SCENE)/%.o
	@mkdir -p $(@D) && for of in o su ci; do [ ! -e $(<:o=)$$of ] || ln -f $(<:o=)$$of $(@:o=)$$of || exit 1; done

$(IMAGE)/model.o: $(BUILD)/$(NAME)/summary.json $(IMAGE)/options
	$(say) $(TARGET) $(BUILD)/$(NAME)/model.c
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $(BUILD)/$(NAME)/model.c -o $@

.SECONDARY: $(SERVO_TARGET) $(PORT_TARGET) $(IMAGE)/model.o
$(addprefix $(IMAGE)/port/,replay.o loop.o loop_pair.o loop_body.o loop_body_pair.o loop_modes.o example.o deform.o body.o grasp.o pair.o modes.o modes_pair.o grasp_modes.o): $(BUILD)/$(NAME)/summary.json

# Only where the scene has [tables] display_rows: make $(BUILD)/NAME/firmware/TARGET/deform.elf NAME=... TARGET=...
$(IMAGE)/deform.elf: $(IMAGE)/display.o
# Only where the body is not held.
$(IMAGE)/body.elf: private STACK = 4K
# Only where it has two fingers besides, whose coupling takes the room.
$(IMAGE)/grasp.elf: private override FLASH = 512K
$(IMAGE)/grasp.elf: private RAM = 32K
$(IMAGE)/grasp.elf: private STACK = 12K
# Only where the body rings.
$(IMAGE)/modes.elf: private STACK = 4K
# And has two fingers.
$(IMAGE)/modes_pair.elf $(IMAGE)/grasp_modes.elf: private override FLASH = 512K
$(IMAGE)/modes_pair.elf $(IMAGE)/grasp_modes.elf: private RAM = 32K
$(IMAGE)/modes_pair.elf $(IMAGE)/grasp_modes.elf: private STACK = 12K
$(IMAGE)/display.o: $(BUILD)/$(NAME)/summary.json $(IMAGE)/options
	$(say) $(TARGET) $(BUILD)/$(NAME)/display.c
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $(BUILD)/$(NAME)/display.c -o $@

# Options are a dependency too: written only when they change.
.PHONY: FORCE
$(IMAGE)/options: private LINKED = $(TARGET_LDFLAGS)
$(IMAGE)/options $(FOR_EVERY_SCENE)/options: FORCE | $(BUILD)/setup-cross.stamp
	@mkdir -p $(@D)
	@echo '$(TARGET_CC) $(TARGET_CFLAGS) $(LINKED)' | cmp -s - $@ || echo '$(TARGET_CC) $(TARGET_CFLAGS) $(LINKED)' >$@

define link_image
	$(say) LINK $@
	$(Q)$(TARGET_CC) $(TARGET_LDFLAGS) -Wl,-Map=$(@:.elf=.map) -o $@ $(filter %.o,$^) -lgcc
	$(Q)$(CROSS_$(TARGET))objcopy -O binary $@ $(@:.elf=.bin)
	$(Q)$(CROSS_$(TARGET))objcopy -O ihex $@ $(@:.elf=.hex)
	$(Q)$(CROSS_$(TARGET))nm $@ >$(@:.elf=.sym)
endef
IN_EVERY_IMAGE = $(SERVO_TARGET) $(PORT_TARGET) $(IMAGE)/model.o $(wildcard firmware/port/*.ld)

$(IMAGE)/%.elf: $(IMAGE)/port/%.o $(IN_EVERY_IMAGE)
	$(link_image)

# The same loop behind two kinds of line.
$(IMAGE)/loop.elf: $(IMAGE)/port/haptable_line_semihosting.o
$(IMAGE)/uart.elf: $(IMAGE)/port/loop.o $(IMAGE)/port/$(UART_$(TARGET):.c=.o) $(IN_EVERY_IMAGE)
	$(link_image)

# Only where the scene has two fingers.
LOOPS_OF_TWO = $(addprefix $(IMAGE)/,$(if $(wildcard $(BUILD)/$(NAME)/coupling*.npy),loop_pair.elf uart_pair.elf))
$(IMAGE)/loop_pair.elf $(IMAGE)/uart_pair.elf: private STACK = 8K
$(IMAGE)/loop_pair.elf: $(IMAGE)/port/haptable_line_semihosting.o
$(IMAGE)/uart_pair.elf: $(IMAGE)/port/loop_pair.o $(IMAGE)/port/$(UART_$(TARGET):.c=.o) $(IN_EVERY_IMAGE)
	$(link_image)

# Only where nothing holds the body, under one finger or two.
LOOPS_OF_BODY = $(addprefix $(IMAGE)/,$(if $(wildcard $(BUILD)/$(NAME)/body.json),$(if $(LOOPS_OF_TWO),loop_body_pair.elf uart_body_pair.elf,loop_body.elf uart_body.elf)))
# Only where it rings, is held and has one finger.
LOOPS_OF_MODES = $(addprefix $(IMAGE)/,$(if $(wildcard $(BUILD)/$(NAME)/modes.json),$(if $(LOOPS_OF_TWO)$(LOOPS_OF_BODY),,loop_modes.elf uart_modes.elf)))
$(IMAGE)/loop_modes.elf $(IMAGE)/uart_modes.elf: private STACK = 4K
$(IMAGE)/loop_body.elf $(IMAGE)/uart_body.elf: private STACK = 4K
$(IMAGE)/loop_body_pair.elf $(IMAGE)/uart_body_pair.elf: private override FLASH = 512K
$(IMAGE)/loop_body_pair.elf $(IMAGE)/uart_body_pair.elf: private RAM = 32K
$(IMAGE)/loop_body_pair.elf $(IMAGE)/uart_body_pair.elf: private STACK = 12K
$(IMAGE)/loop_body.elf $(IMAGE)/loop_body_pair.elf $(IMAGE)/loop_modes.elf: $(IMAGE)/port/haptable_line_semihosting.o
$(IMAGE)/uart_body.elf $(IMAGE)/uart_body_pair.elf $(IMAGE)/uart_modes.elf: $(IMAGE)/uart_%.elf: $(IMAGE)/port/loop_%.o $(IMAGE)/port/$(UART_$(TARGET):.c=.o) $(IN_EVERY_IMAGE)
	$(link_image)

# Reads its tables into RAM: any mode on any body, on a board that has the room.
$(IMAGE)/measure.elf: private override FLASH = 256K
$(IMAGE)/measure.elf: private RAM = 2M
$(IMAGE)/measure.elf: private STACK = 8K
$(IMAGE)/measure.elf: $(IMAGE)/port/measure.o $(IMAGE)/port/haptable_model_reader.o $(filter-out %/model.o,$(IN_EVERY_IMAGE))
	$(link_image)

# The same for two fingers, whose scene's own image is pair.elf.
$(IMAGE)/pair.elf: private STACK = 8K
$(IMAGE)/measure_pair.elf: private override FLASH = 256K
$(IMAGE)/measure_pair.elf: private RAM = 2M
$(IMAGE)/measure_pair.elf: private STACK = 8K
$(IMAGE)/measure_pair.elf: $(IMAGE)/port/measure_pair.o $(IMAGE)/port/haptable_model_reader.o $(IMAGE)/port/haptable_pair_reader.o $(filter-out %/model.o,$(IN_EVERY_IMAGE))
	$(link_image)

$(IMAGE)/size.txt: $(addprefix $(IMAGE)/,replay.elf loop.elf uart.elf example.elf) $(LOOPS_OF_TWO) $(LOOPS_OF_BODY) $(LOOPS_OF_MODES) scripts/size.sh scripts/stack.sh
	$(Q)CROSS=$(CROSS_$(TARGET)) sh scripts/size.sh $(IMAGE) replay >$@.beside && mv $@.beside $@
endif
