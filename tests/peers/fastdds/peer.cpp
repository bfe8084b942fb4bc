// A robot on Fast DDS: publishes a sonar's ranges and odometry at 50 Hz under names of ROS 2, and obeys Twist.
//
//     peer DOMAIN NAMESPACE [reliable|best_effort] [humble] [image WIDTH HEIGHT]
//
// Prints `sent TOPIC HEX` for the first message of each topic, then `ready`, and `got cmd_vel HEX X Z` for each Twist
// unlike the last. Ends with 0 after the first that moves, with 1 where none came within 300 s.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include "messages.hpp"

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

static std::string hex(const unsigned char* bytes, size_t count) {
    std::string text;
    char two[3];
    for (size_t i = 0; i < count; ++i) {
        std::snprintf(two, sizeof two, "%02x", bytes[i]);
        text += two;
    }
    return text;
}

// What says a type to Fast DDS, and keeps the bytes of the last message that went through it.
template <class Message>
class Type : public TopicDataType {
public:
    Type() {
        setName(Message::type);
        m_typeSize = 1U << 20;
        m_isGetKeyDefined = false;
        auto_fill_type_information(false), auto_fill_type_object(false);  // as with ROS 2: names only
    }

    bool serialize(void* message, SerializedPayload_t* payload) override {
        FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
        Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
        payload->encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
        cdr.serialize_encapsulation();
        auto put = [&cdr](auto& field) { cdr << field; };
        static_cast<Message*>(message)->through(put);
        payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
        bytes = hex(payload->data, payload->length);
        return true;
    }

    bool deserialize(SerializedPayload_t* payload, void* message) override {
        FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
        Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
        cdr.read_encapsulation();
        auto take = [&cdr](auto& field) { cdr >> field; };
        static_cast<Message*>(message)->through(take);
        bytes = hex(payload->data, payload->length);
        return true;
    }

    std::function<uint32_t()> getSerializedSizeProvider(void*) override {
        return [this] { return m_typeSize; };
    }
    void* createData() override { return new Message; }
    void deleteData(void* message) override { delete static_cast<Message*>(message); }
    bool getKey(void*, InstanceHandle_t*, bool) override { return false; }

    std::string bytes;
};

class Commands : public DataReaderListener {
public:
    explicit Commands(Type<Twist>* type) : type_(type) {}

    void on_data_available(DataReader* reader) override {
        Twist twist;
        SampleInfo info;
        while (reader->take_next_sample(&twist, &info) == ReturnCode_t::RETCODE_OK) {
            if (!info.valid_data || type_->bytes == last_) continue;
            last_ = type_->bytes;
            std::printf("got cmd_vel %s %g %g\n", last_.c_str(), twist.speeds[0], twist.speeds[5]);
            std::fflush(stdout);
            if (twist.speeds[0] != 0 || twist.speeds[5] != 0) moved = true;
        }
    }

    std::atomic<bool> moved{false};

private:
    Type<Twist>* type_;
    std::string last_;
};

template <class Message>
class Topic_ {
public:
    Topic_(DomainParticipant* of, Publisher* publisher, const std::string& name, const DataWriterQos& quality)
        : type_(new Type<Message>), name_(name) {
        TypeSupport support(type_);
        support.register_type(of);
        Topic* topic = of->create_topic("rt" + name, Message::type, TOPIC_QOS_DEFAULT);
        writer_ = publisher->create_datawriter(topic, quality);
    }

    void send(Message& message) {
        writer_->write(&message);
        if (!said_) std::printf("sent %s %s\n", name_.c_str(), type_->bytes.c_str());
        said_ = true;
    }

private:
    Type<Message>* type_;
    std::string name_;
    DataWriter* writer_ = nullptr;
    bool said_ = false;
};

int main(int count, char** given) {
    if (count < 3) return std::fprintf(stderr, "peer DOMAIN NAMESPACE [best_effort] [humble] [image W H]\n"), 2;
    const std::string space = given[2];
    Range range;
    Odometry odometry;
    Image image;
    DataWriterQos sending = DATAWRITER_QOS_DEFAULT;
    sending.reliability().kind = RELIABLE_RELIABILITY_QOS;
    sending.history().depth = 5;
    for (int i = 3; i < count; ++i) {
        if (!std::strcmp(given[i], "best_effort")) sending.reliability().kind = BEST_EFFORT_RELIABILITY_QOS;
        if (!std::strcmp(given[i], "humble")) range.has_variance = false;
        if (!std::strcmp(given[i], "image")) image.fill(std::atoi(given[i + 1]), std::atoi(given[i + 2])), i += 2;
    }
    auto* factory = DomainParticipantFactory::get_instance();
    DomainParticipant* participant = factory->create_participant(std::atoi(given[1]), PARTICIPANT_QOS_DEFAULT);
    if (participant == nullptr) return std::fprintf(stderr, "the domain cannot be joined\n"), 2;
    Publisher* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
    Topic_<Range> ranges(participant, publisher, space + "/sonar", sending);
    Topic_<Odometry> odometries(participant, publisher, space + "/odom", sending);
    std::unique_ptr<Topic_<Image>> images;
    if (!image.data.empty())
        images = std::make_unique<Topic_<Image>>(participant, publisher, space + "/image", sending);

    auto* type = new Type<Twist>;
    TypeSupport support(type);
    support.register_type(participant);
    Topic* commands = participant->create_topic("rt" + space + "/cmd_vel", Twist::type, TOPIC_QOS_DEFAULT);
    Subscriber* subscriber = participant->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
    Commands obeying(type);
    DataReaderQos receiving = DATAREADER_QOS_DEFAULT;
    receiving.reliability().kind = RELIABLE_RELIABILITY_QOS;
    subscriber->create_datareader(commands, receiving, &obeying);

    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(300);
    for (bool said = false; !obeying.moved && std::chrono::steady_clock::now() < until; said = true) {
        ranges.send(range);
        odometries.send(odometry);
        if (images) images->send(image);
        if (!said) std::printf("ready\n"), std::fflush(stdout);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    participant->delete_contained_entities();
    factory->delete_participant(participant);
    return obeying.moved ? 0 : 1;
}
