/* Nodes that every export of Understudy to BehaviorTree.CPP 4 uses. A value that is absent is NaN. */
#ifndef UNDERSTUDY_NODES_HPP
#define UNDERSTUDY_NODES_HPP

#include <behaviortree_cpp/bt_factory.h>

#include <cmath>
#include <limits>
#include <string>

#ifdef __FAST_MATH__
#error "absent readings are NaN, which -ffast-math does not allow"
#endif

namespace understudy
{
constexpr double ABSENT = std::numeric_limits<double>::quiet_NaN();

inline bool is_absent(double x)
{
    return x != x;
}

/* The rounding is that of Understudy, so that equally many ticks always give the same number. */
inline double measure_elapsed(double now, double since)
{
    const double steps = now < 4194304.0 ? 1e9 : 1e6;
    return std::floor((now - since) * steps + 0.5) / steps;
}

inline double finite_or_absent(double x)
{
    return is_absent(x - x) ? ABSENT : x;
}

inline double wrap(double x, double period)
{
    double wrapped = std::fmod(x, period);
    if (wrapped < 0)
        wrapped += period;
    return wrapped >= period ? 0 : wrapped;
}

inline int to_label(double x, int labels)
{
    return x >= 0 && x < labels ? static_cast<int>(x) : -1;
}

inline double absolute(double x)
{
    return std::fabs(x);
}

inline double root(double x)
{
    return std::sqrt(x);
}

inline double lesser(double x, double y)
{
    return is_absent(x) || is_absent(y) ? ABSENT : x < y ? x : y;
}

inline double greater(double x, double y)
{
    return is_absent(x) || is_absent(y) ? ABSENT : x > y ? x : y;
}

inline double or_rest(double x, double rest)
{
    return is_absent(x - x) ? rest : x;
}

template <class T>
T read_port(const BT::TreeNode &node, const std::string &port)
{
    const auto found = node.getInput<T>(port);
    if (!found)
        throw BT::RuntimeError("node [" + node.name() + "] cannot read port [" + port + "]: " + found.error());
    return found.value();
}

inline double read_number(const BT::TreeNode &node, const std::string &port)
{
    return read_port<double>(node, port);
}

inline int read_label(const BT::TreeNode &node, const std::string &port)
{
    return read_port<int>(node, port);
}

/* A question about a value. Each answers no if the value is absent, but for IsAbsent. */
class Question : public BT::ConditionNode
{
public:
    using BT::ConditionNode::ConditionNode;

    BT::NodeStatus tick() override
    {
        return holds(read_number(*this, "value")) ? BT::NodeStatus::SUCCESS : BT::NodeStatus::FAILURE;
    }

protected:
    virtual bool holds(double value) const = 0;
};

class IsAbsent : public Question
{
public:
    using Question::Question;

    static BT::PortsList providedPorts()
    {
        return {BT::InputPort<double>("value")};
    }

protected:
    bool holds(double value) const override
    {
        return is_absent(value);
    }
};

class IsBelow : public Question
{
public:
    using Question::Question;

    static BT::PortsList providedPorts()
    {
        return {BT::InputPort<double>("value"), BT::InputPort<double>("limit")};
    }

protected:
    bool holds(double value) const override
    {
        return value < read_number(*this, "limit");
    }
};

class IsAtLeast : public Question
{
public:
    using Question::Question;

    static BT::PortsList providedPorts()
    {
        return {BT::InputPort<double>("value"), BT::InputPort<double>("limit")};
    }

protected:
    bool holds(double value) const override
    {
        return value >= read_number(*this, "limit");
    }
};

/* Whether a value is from low to below high; if low is above high, the arc goes over the seam of the circle. */
class IsInArc : public Question
{
public:
    using Question::Question;

    static BT::PortsList providedPorts()
    {
        return {BT::InputPort<double>("value"), BT::InputPort<double>("low"), BT::InputPort<double>("high")};
    }

protected:
    bool holds(double value) const override
    {
        const double low = read_number(*this, "low");
        const double high = read_number(*this, "high");
        return low <= high ? low <= value && value < high : low <= value || value < high;
    }
};

class IsOffArc : public IsInArc
{
public:
    using IsInArc::IsInArc;

protected:
    bool holds(double value) const override
    {
        return !is_absent(value) && !IsInArc::holds(value);
    }
};

/* Writes the seconds that have passed since a time; absent if that is. */
class MeasureElapsed : public BT::SyncActionNode
{
public:
    using BT::SyncActionNode::SyncActionNode;

    static BT::PortsList providedPorts()
    {
        return {BT::InputPort<double>("now"), BT::InputPort<double>("since"), BT::OutputPort<double>("elapsed")};
    }

    BT::NodeStatus tick() override
    {
        setOutput("elapsed", measure_elapsed(read_number(*this, "now"), read_number(*this, "since")));
        return BT::NodeStatus::SUCCESS;
    }
};

template <class T>
void register_once(BT::BehaviorTreeFactory &factory, const std::string &type)
{
    if (factory.builders().count(type) == 0)
        factory.registerNodeType<T>(type);
}

inline void register_nodes(BT::BehaviorTreeFactory &factory)
{
    register_once<IsAbsent>(factory, "IsAbsent");
    register_once<IsBelow>(factory, "IsBelow");
    register_once<IsAtLeast>(factory, "IsAtLeast");
    register_once<IsInArc>(factory, "IsInArc");
    register_once<IsOffArc>(factory, "IsOffArc");
    register_once<MeasureElapsed>(factory, "MeasureElapsed");
}
} // namespace understudy

#endif
