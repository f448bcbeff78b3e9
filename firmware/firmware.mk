# The servo of one scene as an image for a microcontroller: build/<name>/firmware/<target>/. Included by the Makefile.
#
#   haptable.h, *.c + model.c + port/ -> objects -> ELF, bin, map -> size table and checks

TARGET ?= cortex-m7
TARGETS = cortex-m4 cortex-m7 cortex-m33 rv32
override TARGET := $(or $(filter $(TARGETS),$(call plain,TARGET)),$(error TARGET=$(TARGET) is none of: $(TARGETS)))
# What the part has; by default what a scene takes, as its files say. The linker stops where the image does not fit.
HAS_TWO = $(wildcard $(BUILD)/$(NAME)/coupling*.npy)
MOVES = $(wildcard $(BUILD)/$(NAME)/body.json $(BUILD)/$(NAME)/modes.json)
FLASH ?= $(or $(and $(filter scene-images,$(MAKECMDGOALS)),$(FLASH_OF_$(NAME))),$(if $(HAS_TWO),512K,256K))
RAM ?= $(if $(HAS_TWO),32K,16K)
STACK ?= $(if $(HAS_TWO),12K,$(if $(MOVES),4K,2K))
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
# Where flash and RAM begin: QEMU's mps2-an386, an500, an505 (secure) and virt. An STM32F4 has its flash at 0x08000000, an
# STM32L5 at 0x0C000000.
FLASH_AT_cortex-m4  = 0x00000000
FLASH_AT_cortex-m7  = 0x00000000
FLASH_AT_cortex-m33 = 0x10000000
FLASH_AT_rv32       = 0x80000000
RAM_AT_cortex-m4  = 0x20000000
RAM_AT_cortex-m7  = 0x20000000
RAM_AT_cortex-m33 = 0x38000000
RAM_AT_rv32       = 0x80400000
ENTRY_rv32 = -Wl,-e,haptable_port_reset
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
comma = ,
TARGET_LDFLAGS = $(CORE_$(TARGET)) -nostdlib -nostartfiles -Wl,--gc-sections -Wl,--fatal-warnings $(ENTRY_$(TARGET)) \
    $(addprefix -Wl$(comma)--defsym=HAPTABLE_PORT_,FLASH_AT=$(FLASH_AT_$(TARGET)) RAM_AT=$(RAM_AT_$(TARGET)) FLASH=$(FLASH) RAM=$(RAM) STACK=$(STACK)) \
    -T firmware/port/haptable.ld

# firmware: the servo of one scene for a microcontroller, with its size (make firmware SCENE=... TARGET=cortex-m7)
.PHONY: firmware
firmware: $(BUILD)/setup-cross.stamp
	@$(MAKE) --no-print-directory scene
	@name=$$($(BUILD)/bin/haptable-precompute --print-name -- "$$HAPTABLE_SCENE") && \
	$(MAKE) --no-print-directory $(BUILD)/$$name/firmware/$(TARGET)/size.txt NAME=$$name && \
	cat $(BUILD)/$$name/firmware/$(TARGET)/size.txt

# firmware-diff: what the image's code, tables, state and stack grew by against main (make firmware-diff AGAINST=v0.1.0 TARGET=rv32)
AGAINST ?= main
$(call as_given,AGAINST)
.PHONY: firmware-diff
firmware-diff: firmware
	@sh scripts/firmware-against.sh "$$HAPTABLE_AGAINST" $(BUILD) '$(MAKE)' "SCENE=$$HAPTABLE_SCENE" TARGET=$(TARGET) TARGET_OPT=$(TARGET_OPT)

# misra: where firmware/*.c deviates from MISRA C:2012, by cppcheck's addon; firmware/misra.txt says why
.PHONY: misra
misra: $(BUILD)/setup-lint.stamp
	@sh scripts/misra.sh --list

# loop: the servo on a microcontroller in a closed loop over LCM (make loop TARGET=cortex-m7; LINE=uart or LINE=/dev/ttyACM0)
LINE ?= pipes
$(call as_given,LINE)
$(call as_given,DEVICE_OPTIONS)
BAUD ?= 1000000
LOOP_SECONDS ?= 10
.PHONY: loop
loop: firmware
	@name=$$($(BUILD)/bin/haptable-precompute --print-name -- "$$HAPTABLE_SCENE") && \
	BUILD=$(BUILD) LINE="$$HAPTABLE_LINE" BAUD=$(BAUD) SECONDS_=$(LOOP_SECONDS) LOCKSTEP=$(LOCKSTEP) DEVICE_OPTIONS="$$HAPTABLE_DEVICE_OPTIONS" \
	sh scripts/loop.sh $$name "$$HAPTABLE_SCENE" $(TARGET)

# The images that the tests run: scenes of every combination on every target, the cube in 64 KiB; without cross
# compilers, none. And scenes whose servo runs on the host alone
IMAGE_SCENES = meshes/cube.toml meshes/mouse.toml meshes/free-cube.toml meshes/cube-two.toml \
    $(addprefix tests/firmware/,display.toml modes.toml grasp.toml squeeze.toml wobble.toml hands.toml tool.toml)
HOST_SCENES = meshes/cube-hand.toml meshes/liver-spatula.toml
OF_cube = measure.elf
FLASH_OF_cube = 64K
OF_display = deform.elf
.PHONY: images
images: $(BUILD)/host/target/count.so $(IMAGE_SCENES:%=image-scene/%) $(HOST_SCENES:%=image-scene/%)
	@if sh scripts/setup.sh cross; then $(MAKE) --no-print-directory $(TARGETS:%=images-for-%); \
	else echo "no cross compilers: the tests on microcontrollers skip"; fi

# Scenes side by side, then the targets: what a target's images share is made in the first one's turn.
.PHONY: $(IMAGE_SCENES:%=image-scene/%) $(HOST_SCENES:%=image-scene/%) $(TARGETS:%=images-for-%)
$(IMAGE_SCENES:%=image-scene/%) $(HOST_SCENES:%=image-scene/%): image-scene/%: all $(SERVO)
	@$(MAKE) --no-print-directory scene-alone SCENE=$*
$(TARGETS:%=images-for-%): images-for-%: | $(BUILD)/setup-cross.stamp
	@for scene in $(IMAGE_SCENES); do \
	name=$$($(BUILD)/bin/haptable-precompute --print-name -- $$scene) && \
	$(MAKE) --no-print-directory scene-images NAME=$$name SCENE=$$scene TARGET=$* || exit 1; done

.PHONY: scene-images
scene-images: $(addprefix $(BUILD)/$(NAME)/firmware/$(TARGET)/,size.txt $(OF_$(NAME)))

# instructions: count the instructions of a tick on every emulated target
.PHONY: instructions
instructions: images $(BUILD)/bin/haptable-count $(BUILD)/setup-lab.stamp
	$(LAB) instructions $(BUILD)/cube $(BUILD)/mouse

$(BUILD)/host/target/count.so: host/target/plugin/count.c | $(BUILD)/setup.stamp
	$(say) C $<
	@mkdir -p $(@D)
	$(Q)$(CC) -std=c11 -O2 -Wall -Wextra $(WERROR) -shared -fPIC $< -o $@

ifneq ($(NAME),)
IMAGE = $(BUILD)/$(NAME)/firmware/$(TARGET)
SERVO_TARGET = $(patsubst firmware/%.c,$(IMAGE)/%.o,$(wildcard firmware/*.c))
PORT_TARGET = $(addprefix $(IMAGE)/port/,$(addsuffix .o,$(basename $(PORT_$(TARGET)) haptable_semihosting haptable_memory haptable_ticks)))

$(IMAGE)/%.o: firmware/%.c $(IMAGE)/options
	$(say) $(TARGET) $<
	@mkdir -p $(@D)
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -I$(BUILD)/$(NAME) -c $< -o $@

# What reads no scene's model.h is compiled once for a target; every image has the same files in its folder.
FOR_EVERY_SCENE = $(BUILD)/firmware/$(TARGET)
OF_EVERY_SCENE = $(SERVO_TARGET) $(PORT_TARGET) $(addprefix $(IMAGE)/port/,$(UART_$(TARGET):.c=.o) \
    haptable_serial_semihosting.o haptable_scene_reader.o)
$(FOR_EVERY_SCENE)/%.o: firmware/%.c $(FOR_EVERY_SCENE)/options
	$(say) $(TARGET) $<
	@mkdir -p $(@D)
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $< -o $@

$(FOR_EVERY_SCENE)/%.o: firmware/%.S $(FOR_EVERY_SCENE)/options
	$(say) $(TARGET) $<
	@mkdir -p $(@D)
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $< -o $@

$(OF_EVERY_SCENE): $(IMAGE)/shared ;
$(IMAGE)/shared: $(OF_EVERY_SCENE:$(IMAGE)/%=$(FOR_EVERY_SCENE)/%)
	@mkdir -p $(IMAGE)/port
	@$(call link_into,$(IMAGE),$(filter-out $(FOR_EVERY_SCENE)/port/%,$(^:.o=)))
	@$(call link_into,$(IMAGE)/port,$(filter $(FOR_EVERY_SCENE)/port/%,$(^:.o=)))
	@touch $@
link_into = set --; for of in $(foreach of,$(2),$(of).o $(of).su $(of).ci); do [ ! -e $$of ] || set -- "$$@" $$of; done; \
    ln -f "$$@" $(1)

$(IMAGE)/model.o: $(BUILD)/$(NAME)/model.c $(IMAGE)/options
	$(say) $(TARGET) $(BUILD)/$(NAME)/model.c
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $(BUILD)/$(NAME)/model.c -o $@

.SECONDARY: $(SERVO_TARGET) $(PORT_TARGET) $(IMAGE)/model.o
$(addprefix $(IMAGE)/port/,replay.o loop.o example.o example_tool.o deform.o): $(BUILD)/$(NAME)/model.h

# Only where the scene has [tables] display_rows: make $(BUILD)/NAME/firmware/TARGET/deform.elf NAME=... TARGET=...
$(IMAGE)/deform.elf: $(IMAGE)/display.o
$(IMAGE)/display.o: $(BUILD)/$(NAME)/display.c $(IMAGE)/options
	$(say) $(TARGET) $(BUILD)/$(NAME)/display.c
	$(Q)$(TARGET_CC) $(TARGET_CFLAGS) -c $(BUILD)/$(NAME)/display.c -o $@

# Options are a dependency too: written only when they change. An object whose file is gone goes too: tests link all that
# are there.
GONE = $(basename $(filter-out $(OF_EVERY_SCENE) $(addprefix $(IMAGE)/,model.o display.o),$(wildcard $(IMAGE)/*.o)))
.PHONY: FORCE
$(IMAGE)/options: private LINKED = $(TARGET_LDFLAGS)
$(IMAGE)/options $(FOR_EVERY_SCENE)/options: FORCE | $(BUILD)/setup-cross.stamp
	@mkdir -p $(@D) && rm -f $(addsuffix .o,$(GONE)) $(addsuffix .ci,$(GONE)) $(addsuffix .su,$(GONE))
	@echo '$(TARGET_CC) $(TARGET_CFLAGS) $(LINKED)' | cmp -s - $@ || echo '$(TARGET_CC) $(TARGET_CFLAGS) $(LINKED)' >$@

define link_image
	$(say) LINK $@
	$(Q)$(TARGET_CC) $(TARGET_LDFLAGS) -Wl,-Map=$(@:.elf=.map) -o $@ $(filter %.o,$^) -lgcc
	$(Q)$(CROSS_$(TARGET))objcopy -O binary $@ $(@:.elf=.bin)
	$(Q)$(CROSS_$(TARGET))objcopy -O ihex $@ $(@:.elf=.hex)
	$(Q)$(CROSS_$(TARGET))nm $@ >$(@:.elf=.sym)
endef
IN_EVERY_IMAGE = $(SERVO_TARGET) $(PORT_TARGET) $(IMAGE)/model.o firmware/port/haptable.ld

$(IMAGE)/%.elf: $(IMAGE)/port/%.o $(IN_EVERY_IMAGE)
	$(link_image)

# A tool's hand has an orientation.
EXAMPLE = $(if $(wildcard $(BUILD)/$(NAME)/tool.json),example_tool,example)
$(IMAGE)/example.elf: $(IMAGE)/port/$(EXAMPLE).o $(IN_EVERY_IMAGE)
	$(link_image)

# The same loop behind two kinds of line.
$(IMAGE)/loop.elf: $(IMAGE)/port/haptable_serial_semihosting.o
$(IMAGE)/uart.elf: $(IMAGE)/port/loop.o $(IMAGE)/port/$(UART_$(TARGET):.c=.o) $(IN_EVERY_IMAGE)
	$(link_image)

# Reads its tables into RAM: any scene, on a board that has the room.
$(IMAGE)/measure.elf: private override FLASH = 256K
$(IMAGE)/measure.elf: private override RAM = 2M
$(IMAGE)/measure.elf: private override STACK = 12K
$(IMAGE)/measure.elf: $(IMAGE)/port/measure.o $(IMAGE)/port/haptable_scene_reader.o $(filter-out %/model.o,$(IN_EVERY_IMAGE))
	$(link_image)

$(IMAGE)/size.txt: $(addprefix $(IMAGE)/,replay.elf loop.elf uart.elf example.elf) scripts/size.sh scripts/stack.py
	$(Q)CROSS=$(CROSS_$(TARGET)) sh scripts/size.sh $(IMAGE) replay >$@.beside && mv $@.beside $@
endif
