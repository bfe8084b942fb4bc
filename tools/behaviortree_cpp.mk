# Builds BehaviorTree.CPP, whose sources are in the source distribution of behaviortreepy, for the tests of exports:
# make -f tools/behaviortree_cpp.mk -j2

PIP ?= .venv/bin/pip
OUT = build/behaviortree_cpp
S = $(OUT)/source
LIBRARY = $(OUT)/lib/libbehaviortree_cpp.so
KEPT = $(wildcard $S/src/*.cpp $S/src/actions/*.cpp $S/src/decorators/*.cpp $S/src/controls/*.cpp)
SOURCES = $(filter-out %_WIN.cpp %/example.cpp %/manual_node.cpp,$(KEPT)) $S/3rdparty/tinyxml2/tinyxml2.cpp
OBJECTS = $(patsubst %.cpp,$(OUT)/objects/%.o,$(notdir $(SOURCES)))
THIRD = $(addprefix -I$S/3rdparty/,. lexy/include tinyxml2 minicoro minitrace flatbuffers)
FLAGS = -std=c++17 -O0 -fPIC -w -DLEXY_HAS_UNICODE_DATABASE -DLEXY_EXPERIMENTAL -DBTCPP_LIBRARY_VERSION='"4.8.2"'

.PHONY: all
all: $S/package.xml
	+$(MAKE) -f tools/behaviortree_cpp.mk $(LIBRARY)

$S/package.xml: requirements-dev.lock
	mkdir -p $(OUT)/lib $(OUT)/objects
	sed -n '/^behaviortreepy==/,/[^\\]$$/p' requirements-dev.lock > $(OUT)/requirements.txt
	$(PIP) download --quiet --no-deps --no-binary :all: --require-hashes -r $(OUT)/requirements.txt --dest $(OUT)
	tar -xzf $(OUT)/behaviortreepy-*.tar.gz -C $(OUT)
	rm -rf $S && mv $(OUT)/behaviortreepy-*/BehaviorTree.CPP $S
	ln -sfn source/include $(OUT)/include
	touch $@

vpath %.cpp $(sort $(dir $(SOURCES)))
$(OUT)/objects/%.o: %.cpp
	$(CXX) $(FLAGS) -I$S/include -I$S $(THIRD) -c $< -o $@

$(LIBRARY): $(OBJECTS)
	$(CXX) -shared $^ -ldl -pthread -o $@
