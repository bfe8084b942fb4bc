// Publishes on Fast DDS whatever bytes it is told, under any topic and type, unlike what libraries let one do.
//
//     raw DOMAIN
//
// Reads lines `TOPIC TYPE HEX`, names as DDS has them, and answers each with `ok` once it is sent. A line `wait N`
// waits until as many readers were found in all.
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

using namespace eprosima::fastdds::dds;
using Bytes = std::vector<unsigned char>;

class Raw : public TopicDataType {
public:
    explicit Raw(const std::string& name) {
        setName(name.c_str());
        m_typeSize = 1U << 20;
        auto_fill_type_information(false), auto_fill_type_object(false);
    }

    bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
        const Bytes& bytes = *static_cast<Bytes*>(data);
        payload->encapsulation = CDR_LE;
        payload->length = static_cast<uint32_t>(bytes.size());
        std::memcpy(payload->data, bytes.data(), bytes.size());
        return true;
    }
    bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t*, void*) override { return false; }
    std::function<uint32_t()> getSerializedSizeProvider(void*) override {
        return [this] { return m_typeSize; };
    }
    void* createData() override { return new Bytes; }
    void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
    bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

static int readers(const std::map<std::string, DataWriter*>& writers) {
    int found = 0;
    for (const auto& each : writers) {
        PublicationMatchedStatus status;
        each.second->get_publication_matched_status(status);
        found += status.current_count;
    }
    return found;
}

int main(int count, char** given) {
    if (count < 2) return std::fprintf(stderr, "raw DOMAIN\n"), 2;
    auto* participant =
        DomainParticipantFactory::get_instance()->create_participant(std::atoi(given[1]), PARTICIPANT_QOS_DEFAULT);
    if (participant == nullptr) return std::fprintf(stderr, "the domain cannot be joined\n"), 2;
    Publisher* publisher = participant->create_publisher(PUBLISHER_QOS_DEFAULT);
    std::map<std::string, DataWriter*> writers;
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::string topic, type, text;
        words >> topic >> type >> text;
        if (topic == "wait") {
            for (int i = 0; i < 500 && readers(writers) < std::atoi(type.c_str()); ++i)
                std::this_thread::sleep_for(std::chrono::milliseconds(20));
            std::printf("ok\n"), std::fflush(stdout);
            continue;
        }
        if (writers.count(topic) == 0) {
            TypeSupport support(new Raw(type));
            support.register_type(participant);
            DataWriterQos quality = DATAWRITER_QOS_DEFAULT;
            quality.reliability().kind = RELIABLE_RELIABILITY_QOS;
            writers[topic] = publisher->create_datawriter(
                participant->create_topic(topic, type, TOPIC_QOS_DEFAULT), quality);
        }
        Bytes bytes;
        for (size_t i = 0; i + 1 < text.size(); i += 2)
            bytes.push_back(static_cast<unsigned char>(std::stoi(text.substr(i, 2), nullptr, 16)));
        writers[topic]->write(&bytes);
        std::printf("ok\n"), std::fflush(stdout);
    }
    participant->delete_contained_entities();
    return 0;
}
